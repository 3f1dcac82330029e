#include "protocols/modbus/connection_record.hpp"

#include <algorithm>
#include <utility>

#include "protocols/modbus/wire_event.hpp"

namespace aprsim::modbus_server {
namespace {

std::string_view text_of(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

ConnectionRecord::ConnectionRecord(ListenerContext& context, std::string peer)
    : context_(context),
      peer_(std::move(peer)),
      trace_(context.options.listener.trace, context.source, protocols::WireKind::kModbus,
             listener_name(context.options), peer_) {}

void ConnectionRecord::received(std::span<const std::uint8_t> adu, std::string_view fault) {
  trace_.received(text_of(adu), fault);
}

void ConnectionRecord::request(std::span<const std::uint8_t> adu, const std::string& refusal) {
  ++context_.counters.requests;
  received_at_ = Clock::now();
  tap(true, adu, refusal);
}

void ConnectionRecord::reply(std::span<const std::uint8_t> adu) {
  tap(false, adu);
  context_.counters.answer_times.add(Clock::now() - received_at_);
}

void ConnectionRecord::sent(std::span<const std::uint8_t> adus) {
  constexpr std::size_t kLengthAt = 4, kLengthEnd = 6;  // in the MBAP header
  while (adus.size() > kLengthEnd) {
    const std::size_t rest = adus[kLengthAt] * 256U + adus[kLengthAt + 1];
    const std::size_t size = std::min(adus.size(), kLengthEnd + rest);
    trace_.sent(text_of(adus.first(size)));
    adus = adus.subspan(size);
  }
}

void ConnectionRecord::tap(bool from_client, std::span<const std::uint8_t> adu,
                           const std::string& refusal) {
  protocols::WireTap* const tap = context_.options.tap;
  if (!tap) return;
  protocols::WireEvent event = wire_event(adu);
  if (event.poll && !tap->wants_polls()) return;
  const std::chrono::duration<double> since = Clock::now() - received_at_;
  event.source = listener_name(context_.options);
  event.peer = peer_;
  event.identity = identity_;
  event.state = refusal;
  event.from_client = from_client;
  event.time = std::chrono::system_clock::now();
  if (!from_client) event.latency_s = since.count();
  tap->record(std::move(event));
}

}  // namespace aprsim::modbus_server
