#include <algorithm>
#include <cstdint>
#include <string>

#include "protocols/messages/codecs.hpp"
#include "protocols/messages/control_request.hpp"
#include "protocols/messages/write_message.hpp"
#include "world/api/faults/fault_fields.hpp"

namespace aprsim::protocols {

SimTime time_of(const google::protobuf::Duration& span) {
  constexpr std::int64_t kFar = 4'000'000'000;  // s
  return std::chrono::seconds(std::clamp(span.seconds(), -kFar, kFar)) +
         std::chrono::nanoseconds(span.nanos());
}

void Codec<api::WhenCrossing>::write(const api::WhenCrossing& when, v1::CrossingTrigger& message) {
  write_fields(when, message);
  message.set_quantity(std::string(faults::info(when.quantity).name));
  if (when.above) {
    message.set_above(when.limit);
  } else {
    message.set_below(when.limit);
  }
}

Result<void> Codec<api::WhenCrossing>::read(const v1::CrossingTrigger& message,
                                            api::WhenCrossing& when) {
  const faults::QuantityInfo* quantity = faults::find_quantity(message.quantity());
  if (quantity == nullptr) {
    std::string names;
    for (const auto& known : faults::all_quantities()) {
      names += (names.empty() ? "" : ", ") + std::string(known.name);
    }
    return fail(ErrorCode::kNotFound, "crossing",
                "'" + message.quantity().substr(0, 64) + "' is no quantity; there are: " + names);
  }
  if (message.limit_case() == v1::CrossingTrigger::LIMIT_NOT_SET) {
    return fail(ErrorCode::kInvalidArgument, "crossing", "one of above and below must be set");
  }
  when.quantity = quantity->quantity;
  when.robot = message.robot();
  constexpr std::uint32_t kBeyond = 1000;  // no robot has so many joints
  when.joint = static_cast<int>(std::min(message.joint(), kBeyond));
  when.above = message.has_above();
  when.limit = when.above ? message.above() : message.below();
  return {};
}

Result<void> Codec<api::WhenGrasped>::read(const v1::GraspedTrigger& message,
                                           api::WhenGrasped& when) {
  constexpr std::uint32_t kMost = 1'000'000;
  const std::uint32_t count = std::max<std::uint32_t>(message.count(), 1);
  if (count > kMost) {
    return fail(ErrorCode::kInvalidArgument, "grasped",
                "count is " + std::to_string(count) + ", must be at most " + std::to_string(kMost));
  }
  when = {message.robot(), static_cast<int>(count)};
  return {};
}

Result<CommandBody> command_of(const v1::InjectFaultRequest& request,
                               const api::Snapshot& /*snapshot*/) {
  api::InjectFault fault;
  return read_fields(request, fault).map([&]() -> CommandBody {
    return api::FaultCommand(std::move(fault));
  });
}

void write_message(const api::InjectedFault& fault, v1::InjectedFault& message) {
  write_fields(fault, message);
  const faults::KindInfo& kind = faults::info(fault.kind);
  message.set_kind(std::string(kind.name));
  for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
    (*message.mutable_parameters())[std::string(kind.parameters[i].name)] = fault.values[i];
  }
}

void write_message(const faults::KindInfo& kind, v1::FaultKind& message) {
  write_fields(kind, message);
  message.set_target(std::string(faults::pattern_of(kind.target)));
  for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
    write_fields(kind.parameters[i], *message.add_parameters());
  }
}

void write_fault_kinds(v1::ListFaultKindsResponse& message) {
  for (const auto& kind : faults::all_kinds()) write_message(kind, *message.add_kinds());
  for (const auto& quantity : faults::all_quantities()) {
    write_fields(quantity, *message.add_quantities());
  }
}

}  // namespace aprsim::protocols
