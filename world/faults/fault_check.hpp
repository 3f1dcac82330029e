#pragma once

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

  /// By the name of a parameter, which the kind must have.
  [[nodiscard]] double value(std::string_view parameter) const {
    return values[faults::info(kind).parameter(parameter).value()];
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [kind, robot, joint, body, other_body, eye, values, trigger, trigger_robot, trigger_eye,
           duration] = self;
    io(kind, robot, joint, body, other_body, eye, values, trigger, trigger_robot, trigger_eye,
       duration);
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
