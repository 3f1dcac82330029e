#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "world/api/description/cell_description.hpp"
#include "world/api/faults/fault.hpp"
#include "world/base/result.hpp"

namespace aprsim::world {

/// A fault with names resolved: indices into the cell's description, -1 where the kind has none.
struct FaultSpec {
  faults::Kind kind = faults::Kind::kRobotBreakdown;
  int robot = -1, joint = -1, body = -1, other_body = -1, eye = -1;
  std::array<double, faults::kMaxParameters> values{};  ///< of the kind's parameters, SI
  api::FaultTrigger trigger;
  int trigger_robot = -1;  ///< -1 = any, or none
  int trigger_eye = -1;
  std::optional<SimTime> duration;

  /// Value of a parameter, which the kind must have.
  [[nodiscard]] double value(std::string_view parameter) const {
    return values[faults::info(kind).parameter(parameter).value()];
  }

  /// Whether it has the indices that its kind needs.
  [[nodiscard]] bool has_target() const;
  /// Whether the kind's parameters are within their bounds.
  [[nodiscard]] bool has_valid_values() const;
  /// Whether it has the indices that its trigger needs; `joints`: of the trigger's robot.
  [[nodiscard]] bool has_trigger(int joints) const;
  /// Whether kind or trigger concern the conveyor.
  [[nodiscard]] bool needs_belt() const;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [kind, robot, joint, body, other_body, eye, values, trigger, trigger_robot, trigger_eye,
           duration] = self;
    io(kind, robot, joint, body, other_body, eye, values, trigger, trigger_robot, trigger_eye,
       duration);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.index_or_none(In::kRobot, robot, trigger_robot);
    in.index_or_none(In::kPart, body, other_body);
    in.index_or_none(In::kPhotoEye, eye, trigger_eye);
    const auto joints_of = [&](int of) {
      return of < 0 ? 0 : in.counts().robots[static_cast<std::size_t>(of)].joints;
    };
    in.require(joint >= -1 && joint < std::max(joints_of(robot), 1), "a fault of an unknown joint");
    in.require(has_target() && has_valid_values(), "a fault that no cell can have");
    in.require(in.counts().belt || !needs_belt(), "a fault of a belt that does not exist");
    in.require(in.counts().light_curtain || kind != faults::Kind::kCurtainBroken,
               "a fault of a light curtain that does not exist");
    in.require(has_trigger(joints_of(trigger_robot)), "a fault that waits for something unknown");
  }
};

/// Names and numbers of a cell's parts. Indices hold as long as a cell has this very description.
using CellNames = std::shared_ptr<const api::CellDescription>;

/// A request whose names check() has resolved in a description.
struct ResolvedFault {
  CellNames names;
  FaultSpec spec;
};
/// The same of a crossing: index of its robot, -1 where the quantity belongs to none.
struct ResolvedCrossing {
  CellNames names;
  int robot = -1;
};

/// Checks a request and resolves its names in the cell. Errors name the field, its value and what
/// was expected. Thread: any.
[[nodiscard]] Result<FaultSpec> resolve(const api::InjectFault& request,
                                        const api::CellDescription& cell);
[[nodiscard]] Result<int> resolve(const api::WhenCrossing& crossing,
                                  const api::CellDescription& cell);

/// The request as it was resolved when it was checked, if the cell still has that description.
/// Resolves it anew otherwise: bodies may have other numbers since. Errors: as resolve(). Thread:
/// any.
[[nodiscard]] Result<FaultSpec> spec_of(const api::InjectFault& request, const CellNames& names);
/// The same for a run's crossing: index of its robot.
[[nodiscard]] Result<int> robot_of(const api::WhenCrossing& crossing,
                                   const api::ResolvedCrossingPtr& resolved,
                                   const CellNames& names);
/// An event's name that may be reported. Thread: any.
[[nodiscard]] Result<void> check_event(const std::string& event);

/// In words: "when fanuc has placed a sku_part_small_gear"; empty for none.
[[nodiscard]] std::string describe(const api::FaultTrigger& trigger);

}  // namespace aprsim::world
