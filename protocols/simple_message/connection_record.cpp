#include "protocols/simple_message/connection_record.hpp"

#include <utility>

#include "protocols/simple_message/wire_event.hpp"

namespace aprsim::simple_message {

ConnectionRecord::ConnectionRecord(ListenerContext& context, std::string listener, std::string peer)
    : context_(context),
      listener_(std::move(listener)),
      peer_(std::move(peer)),
      trace_(context.options.listener.trace, context.source, protocols::WireKind::kSimpleMessage,
             listener_, peer_) {}

void ConnectionRecord::request(std::string_view bytes, std::string_view fault) {
  ++context_.counters.requests;
  requested_at_ = Clock::now();
  trace_.received(bytes, fault);
  tap(true, bytes, fault);
}

void ConnectionRecord::sent(std::string_view bytes, bool reply) {
  trace_.sent(bytes);
  tap(false, bytes, {});
  if (reply) context_.counters.answer_times.add(Clock::now() - requested_at_);
}

void ConnectionRecord::tap(bool from_client, std::string_view bytes, std::string_view fault) {
  protocols::WireTap* const tap = context_.options.tap;
  if (tap == nullptr) return;
  protocols::WireEvent event = wire_event(bytes, from_client, context_.order);
  if (event.poll && !tap->wants_polls()) return;
  const std::chrono::duration<double> since = Clock::now() - requested_at_;
  event.source = listener_;
  event.peer = peer_;
  event.time = std::chrono::system_clock::now();
  if (!fault.empty()) event.state = fault;
  if (!from_client && !event.poll) event.latency_s = since.count();
  tap->note(std::move(event));
}

}  // namespace aprsim::simple_message
