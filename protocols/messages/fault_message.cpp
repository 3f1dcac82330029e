#include <algorithm>
#include <cstdint>
#include <string>

#include "protocols/messages/control_request.hpp"
#include "protocols/messages/write_message.hpp"

namespace aprsim::protocols {
namespace {

Result<api::FaultTrigger> trigger_of(const v1::InjectFaultRequest& request) {
  switch (request.trigger_case()) {
    case v1::InjectFaultRequest::kAt:
      return api::AtTime{time_of(request.at())};
    case v1::InjectFaultRequest::kPlaced:
      return api::WhenPlaced{request.placed().type(), request.placed().robot()};
    case v1::InjectFaultRequest::kGrasped: {
      constexpr std::uint32_t kMost = 1'000'000;
      const std::uint32_t count = std::max<std::uint32_t>(request.grasped().count(), 1);
      if (count > kMost) {
        return fail(
            ErrorCode::kInvalidArgument, "grasped",
            "count is " + std::to_string(count) + ", must be at most " + std::to_string(kMost));
      }
      return api::WhenGrasped{request.grasped().robot(), static_cast<int>(count)};
    }
    case v1::InjectFaultRequest::kBeam:
      return api::WhenBeamBroken{request.beam().eye()};
    case v1::InjectFaultRequest::kCrossing:
      return to_trigger(request.crossing());
    case v1::InjectFaultRequest::kReported:
      return api::WhenReported{request.reported().event()};
    case v1::InjectFaultRequest::TRIGGER_NOT_SET:
      break;
  }
  return api::FaultTrigger{};
}

v1::InjectedFaultState fault_state(api::FaultState state) {
  switch (state) {
    case api::FaultState::kPending:
      return v1::INJECTED_FAULT_STATE_PENDING;
    case api::FaultState::kActive:
      return v1::INJECTED_FAULT_STATE_ACTIVE;
    case api::FaultState::kEnded:
      return v1::INJECTED_FAULT_STATE_ENDED;
  }
  return v1::INJECTED_FAULT_STATE_UNSPECIFIED;
}

}  // namespace

SimTime time_of(const google::protobuf::Duration& span) {
  constexpr std::int64_t kFar = 4'000'000'000;  // s
  return std::chrono::seconds(std::clamp(span.seconds(), -kFar, kFar)) +
         std::chrono::nanoseconds(span.nanos());
}

Result<api::WhenCrossing> to_trigger(const v1::CrossingTrigger& crossing) {
  api::WhenCrossing out;
  const faults::QuantityInfo* quantity = faults::find_quantity(crossing.quantity());
  if (quantity == nullptr) {
    std::string names;
    for (const auto& known : faults::all_quantities()) {
      names += (names.empty() ? "" : ", ") + std::string(known.name);
    }
    return fail(ErrorCode::kNotFound, "crossing",
                "'" + crossing.quantity().substr(0, 64) + "' is no quantity; there are: " + names);
  }
  if (crossing.limit_case() == v1::CrossingTrigger::LIMIT_NOT_SET) {
    return fail(ErrorCode::kInvalidArgument, "crossing", "one of above and below must be set");
  }
  out.quantity = quantity->quantity;
  out.robot = crossing.robot();
  constexpr std::uint32_t kBeyond = 1000;  // no robot has so many joints
  out.joint = static_cast<int>(std::min(crossing.joint(), kBeyond));
  out.above = crossing.has_above();
  out.limit = out.above ? crossing.above() : crossing.below();
  return out;
}

void write_message(const api::WhenCrossing& when, v1::CrossingTrigger& message) {
  message.set_quantity(std::string(faults::info(when.quantity).name));
  message.set_robot(when.robot);
  message.set_joint(static_cast<std::uint32_t>(when.joint));
  if (when.above) {
    message.set_above(when.limit);
  } else {
    message.set_below(when.limit);
  }
}

Result<api::InjectFault> to_command(const v1::InjectFaultRequest& request) {
  auto trigger = trigger_of(request);
  if (!trigger) return tl::unexpected(trigger.error());
  api::InjectFault out;
  out.kind = request.kind();
  out.target = request.target();
  for (const auto& [name, value] : request.parameters()) out.parameters[name] = value;
  out.trigger = *std::move(trigger);
  if (request.has_duration()) out.duration = time_of(request.duration());
  return out;
}

void write_message(const api::InjectedFault& fault, v1::InjectedFault& message) {
  const faults::KindInfo& kind = faults::info(fault.kind);
  message.set_id(fault.id);
  message.set_ticket(fault.ticket);
  message.set_kind(std::string(kind.name));
  message.set_target(fault.target);
  for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
    (*message.mutable_parameters())[std::string(kind.parameters[i].name)] = fault.values[i];
  }
  message.set_trigger(fault.trigger);
  message.set_state(fault_state(fault.state));
  if (fault.begin_step) message.set_begin_step(*fault.begin_step);
  if (fault.end_step) message.set_end_step(*fault.end_step);
  message.set_note(fault.note);
}

void write_message(const faults::KindInfo& kind, v1::FaultKind& message) {
  message.set_name(std::string(kind.name));
  message.set_target(std::string(faults::pattern_of(kind.target)));
  message.set_momentary(kind.momentary);
  message.set_meaning(std::string(kind.meaning));
  for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
    const faults::Parameter& from = kind.parameters[i];
    auto& parameter = *message.add_parameters();
    parameter.set_name(std::string(from.name));
    parameter.set_unit(std::string(from.unit));
    parameter.set_min(from.min);
    parameter.set_max(from.max);
    parameter.set_default_(from.fallback);
    parameter.set_meaning(std::string(from.meaning));
  }
}

void write_message(const faults::QuantityInfo& quantity, v1::FaultQuantity& message) {
  message.set_name(std::string(quantity.name));
  message.set_unit(std::string(quantity.unit));
  message.set_of_robot(quantity.of_robot);
  message.set_meaning(std::string(quantity.meaning));
}

void write_fault_kinds(v1::ListFaultKindsResponse& message) {
  for (const auto& kind : faults::all_kinds()) write_message(kind, *message.add_kinds());
  for (const auto& quantity : faults::all_quantities()) {
    write_message(quantity, *message.add_quantities());
  }
}

}  // namespace aprsim::protocols
