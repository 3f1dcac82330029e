#include "protocols/modbus/request_executor.hpp"

#include <algorithm>
#include <utility>

#include "protocols/modbus/reply_faults.hpp"

namespace aprsim::modbus_server {

using modbus::ExceptionCode;
using modbus::Verdict;

std::optional<RequestExecutor::Reply> RequestExecutor::execute(
    const modbus::ValidatedRequest& validated) {
  if (const auto injected = injected_exception(*context_.source.latest())) {
    return refuse(validated.adu, *injected);
  }
  if (validated.verdict == Verdict::kRefused) return refuse(validated.adu, validated.exception);
  if (validated.verdict == Verdict::kIdentification) {
    return modbus::identification_reply(validated.adu, validated.identification);
  }
  context_.bank.refresh();
  return validated.request.is_write() ? write(validated) : answer(validated.adu);
}

std::optional<RequestExecutor::Reply> RequestExecutor::write(
    const modbus::ValidatedRequest& validated) {
  const bool stop = context_.bank.is_stop(validated.request);
  const auto ticket = context_.bank.write(validated.request);
  if (!ticket) return refuse(validated.adu, ticket.error());
  if (*ticket == 0) return answer(validated.adu);
  const auto patience = stop ? context_.options.stop_deadline : context_.options.apply_deadline;
  const auto now = Clock::now();
  waiting_ = WaitingWrite{
      *ticket, now, now + patience, {validated.adu.begin(), validated.adu.end()}, stop};
  return std::nullopt;
}

std::optional<RequestExecutor::Reply> RequestExecutor::poll(Clock::time_point now) {
  if (!waiting_) return std::nullopt;
  const bool applied = context_.bank.applied(waiting_->ticket);
  if (!applied && now < waiting_->deadline) return std::nullopt;
  const auto [ticket, since, deadline, adu, stop] = *std::exchange(waiting_, std::nullopt);
  // A stop that is queued takes effect before any later step.
  if (!applied && stop) context_.bank.show(ticket);
  if (applied || stop) return answer(adu);
  context_.log.warn(
      peer_ + ": the simulation did not confirm a write within " +
      std::to_string(duration_cast<std::chrono::milliseconds>(deadline - since).count()) + " ms");
  return refuse(adu, ExceptionCode::kServerDeviceFailure);
}

void RequestExecutor::hurry() {
  if (waiting_) {
    waiting_->deadline =
        std::min(waiting_->deadline, waiting_->since + context_.options.stop_deadline);
  }
}

RequestExecutor::Reply RequestExecutor::answer(std::span<const std::uint8_t> adu) {
  const auto built = context_.replies.build(adu, context_.bank.memory());
  if (!built.empty()) return {built.begin(), built.end()};
  context_.log.warn(peer_ + ": no reply could be encoded");
  return refuse(adu, ExceptionCode::kServerDeviceFailure);
}

RequestExecutor::Reply RequestExecutor::refuse(std::span<const std::uint8_t> adu,
                                               ExceptionCode code) {
  ++context_.counters.exceptions;
  if (auto* const refusals = context_.options.listener.refusals) {
    const int function = adu.size() > 7 ? adu[7] : 0;
    refusals->refused(context_.log.name(), "function " + std::to_string(function) + " of " + peer_ +
                                               ": exception " +
                                               std::to_string(static_cast<int>(code)));
  }
  const auto bytes = modbus::exception_reply(adu, code).bytes;
  return {bytes.begin(), bytes.end()};
}

}  // namespace aprsim::modbus_server
