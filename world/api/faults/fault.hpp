#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "world/api/faults/fault_kinds.hpp"
#include "world/api/values/ticket.hpp"
#include "world/base/time.hpp"

namespace aprsim::world {
struct ResolvedFault;
struct ResolvedCrossing;
}  // namespace aprsim::world

/// Faults that are injected into the cell on purpose, to test a controller (the laboratory's mock
/// failures). The same request comes over gRPC, from the command line and from
/// files.
namespace aprsim::api {

/// At a simulated time since the last reset, or at once where that is over.
struct AtTime {
  SimTime time{};
};
/// A robot releases a gear of a type.
struct WhenPlaced {
  std::string type;   ///< of the gear
  std::string robot;  ///< empty = any
};
/// A robot's n-th grasp from the injection on.
struct WhenGrasped {
  std::string robot;
  int count = 1;  ///< >= 1
};
/// Something comes into the beam of a photo-eye.
struct WhenBeamBroken {
  std::string eye;
};
/// A quantity goes beyond a limit that it has not been beyond.
struct WhenCrossing {
  faults::Quantity quantity = faults::Quantity::kJointPosition;
  std::string robot;  ///< where the quantity is one's
  int joint = 1;      ///< of a joint's position, from 1
  bool above = true;  ///< else below
  double limit = 0;   ///< SI
};
/// A client reports an event of this name, as "order-submitted".
struct WhenReported {
  std::string event;
};
/// The names in a crossing as indices; see world/faults/fault_check.hpp. Opaque outside of `world`.
using ResolvedCrossingPtr = std::shared_ptr<const world::ResolvedCrossing>;
/// The condition on which a fault begins; monostate: it begins at once.
using FaultTrigger = std::variant<std::monostate, AtTime, WhenPlaced, WhenGrasped, WhenBeamBroken,
                                  WhenCrossing, WhenReported>;

inline constexpr std::size_t kMaxFaultText = 128;  ///< bytes of a name or target

/// A request for a fault; world/faults/fault_check.hpp checks it against a cell.
struct InjectFault {
  std::string kind;                          ///< name of a kind (faults/fault_kinds.hpp)
  std::string target;                        ///< as the kind's target is written
  std::map<std::string, double> parameters;  ///< SI; absent ones have the defaults of the kind
  FaultTrigger trigger;
  std::optional<SimTime> duration;  ///< > 0; absent = until it is ended; a momentary kind has none
  /// The same with its names as indices, set by world::check(); null = not checked.
  std::shared_ptr<const world::ResolvedFault> resolved{};
};
/// Ends an active fault or cancels a pending one; fails for other numbers.
struct EndFault {
  std::uint64_t id = 0;
};
/// Reports an event outside the cell to the faults that wait for it.
struct ReportEvent {
  std::string event;
};
using FaultCommand = std::variant<InjectFault, EndFault, ReportEvent>;

enum class FaultState {
  kPending,  ///< waits for its trigger
  kActive,
  kEnded,
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr FaultState last_of(FaultState) { return FaultState::kEnded; }

/// One fault and its state.
struct InjectedFault {
  std::uint64_t id = 0;  ///< counts from 1 since the last reset
  Ticket ticket = 0;     ///< of its injection
  faults::Kind kind = faults::Kind::kRobotBreakdown;
  std::string target;                                   ///< as it was given
  std::string trigger;                                  ///< in words; empty = none
  int robot = -1;                                       ///< index, where the target is one's
  std::array<double, faults::kMaxParameters> values{};  ///< the kind's parameters, SI
  FaultState state = FaultState::kPending;
  std::optional<std::uint64_t> begin_step, end_step;  ///< steps since the last reset
  std::string note;                                   ///< a remark on its end, mostly empty

  /// See world/archive/archive.hpp.
  template <typename In>
  void require_valid(In& in) const {
    in.index_or_none(In::kRobot, robot);
  }
};

inline constexpr std::size_t kMaxOpenFaults = 64;  ///< that wait or last
inline constexpr std::size_t kMaxPastFaults = 64;  ///< the latest that are kept

/// All that wait or last and the latest past ones, by number. Immutable: snapshots share it.
struct InjectedFaults {
  std::vector<InjectedFault> all;

  /// The latest of a kind that lasts, on a robot where one is given; null = none.
  [[nodiscard]] const InjectedFault* active(faults::Kind kind, int robot = -1) const {
    const auto matches = [&](const InjectedFault& fault) {
      return fault.kind == kind && fault.state == FaultState::kActive &&
             (robot < 0 || fault.robot == robot);
    };
    const auto found = std::find_if(all.rbegin(), all.rend(), matches);
    return found == all.rend() ? nullptr : &*found;
  }
  /// A value of a fault by the name of its parameter, which its kind must have.
  [[nodiscard]] static double value(const InjectedFault& fault, std::string_view parameter) {
    return fault.values[faults::info(fault.kind).parameter(parameter).value()];
  }
};
/// Null = none since the last reset.
using InjectedFaultsPtr = std::shared_ptr<const InjectedFaults>;

}  // namespace aprsim::api
