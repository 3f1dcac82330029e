#include "clients/aprsim/text/fault_request.hpp"

#include <cmath>
#include <variant>

namespace aprsim::client {
namespace {

google::protobuf::Duration span_of(double span_s) {
  google::protobuf::Duration span;
  const double whole = std::floor(span_s);
  span.set_seconds(static_cast<std::int64_t>(whole));
  span.set_nanos(static_cast<std::int32_t>(std::floor((span_s - whole) * 1e9)));
  return span;
}

/// Writes the trigger of a fault.
struct TriggerWriter {
  v1::InjectFaultRequest& request;

  void operator()(const faults::WhenPlaced& placed) const {
    request.mutable_placed()->set_type(placed.type);
    request.mutable_placed()->set_robot(placed.robot);
  }
  void operator()(const faults::WhenGrasped& grasped) const {
    request.mutable_grasped()->set_robot(grasped.robot);
    request.mutable_grasped()->set_count(grasped.count);
  }
  void operator()(const faults::WhenBeamBroken& beam) const {
    request.mutable_beam()->set_eye(beam.eye);
  }
  void operator()(const faults::WhenReported& reported) const {
    request.mutable_reported()->set_event(reported.event);
  }
  void operator()(const faults::WhenCrossing& crossing) const {
    auto& out = *request.mutable_crossing();
    out.set_quantity(crossing.quantity);
    out.set_robot(crossing.robot);
    out.set_joint(crossing.joint);
    if (crossing.above) {
      out.set_above(crossing.limit);
    } else {
      out.set_below(crossing.limit);
    }
  }
};

}  // namespace

v1::InjectFaultRequest fault_request(const FaultInjectCommand& command) {
  v1::InjectFaultRequest request;
  request.set_kind(command.kind);
  request.set_target(command.target);
  for (const auto& [name, value] : command.parameters) {
    (*request.mutable_parameters())[name] = value;
  }
  if (command.at_s) *request.mutable_at() = span_of(*command.at_s);
  if (command.when) std::visit(TriggerWriter{request}, *command.when);
  if (command.for_s) *request.mutable_duration() = span_of(*command.for_s);
  return request;
}

}  // namespace aprsim::client
