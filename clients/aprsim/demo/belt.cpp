#include "clients/aprsim/demo/belt.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/demo/bounded_pace.hpp"
#include "clients/aprsim/demo/geometry.hpp"
#include "clients/wires/conveyor_connection.hpp"
#include "modbus/register_map.hpp"

namespace aprsim::client {
namespace {

constexpr double kSpeed_m_s = 0.15;
constexpr double kCreep_m_s = 0.02;    // for the return after an overshoot
constexpr double kEdge_m = 0.1;        // distance that bodies keep from the belt's ends
constexpr double kBeside_m = 0.35;     // the tray stops this far before the robot, along the belt
constexpr double kWorthwhile_m = 0.1;  // shorter distances are not travelled
constexpr double kMaxBeltSlip_m = 0.005;  // between belt and tray, over the whole distance
constexpr auto kBeltTimeout = std::chrono::minutes(2);
// The demo stops the belt from its snapshots: at a higher speed ratio the belt overshoots before
// the stop arrives. It runs back by the overshoot.
constexpr double kPace = 2;
constexpr double kOff_m = 0.02;  // tolerance of the tray's position
constexpr int kRuns = 4;
constexpr auto kStandstillTimeout = std::chrono::seconds(10);
// The speed register's default scaling; with another one the belt is merely faster or slower.
constexpr double kMetresPerSecondPerCount = 1e-5;

/// A tray to bring and how far the belt must run for it, in the belt's x.
struct Plan {
  int body = 0;
  double distance_m = 0;
};

/// The belt's frame and the bodies on it.
class BeltView {
 public:
  BeltView(const v1::CellDescription& cell, const v1::Snapshot& snapshot)
      : cell_(cell),
        snapshot_(snapshot),
        X_CW_(isometry(cell.conveyor().belt_in_world()).inverse()) {}

  [[nodiscard]] double along(int body) const {
    return along(isometry(snapshot_.bodies(body).body_in_world()).translation());
  }
  [[nodiscard]] double along(const Eigen::Vector3d& p_W) const { return (X_CW_ * p_W).x(); }

  /// The tray with parts that is farthest from x, and its distance to x.
  [[nodiscard]] std::optional<Plan> plan(double x) const {
    std::optional<Plan> best;
    for (int i = 0; i < cell_.bodies_size(); ++i) {
      if (cell_.bodies(i).kind() != v1::BODY_KIND_PART_TRAY || !on_belt(i) || !has_gears(i))
        continue;
      const double way = x - along(i);
      const double distance = std::copysign(std::max(std::abs(way) - kBeside_m, 0.0), way);
      if (std::abs(distance) < kWorthwhile_m || !keeps_all(distance)) continue;
      if (!best || std::abs(distance) > std::abs(best->distance_m)) best = Plan{i, distance};
    }
    return best;
  }

 private:
  [[nodiscard]] bool on_belt(int body) const {
    return over_belt(cell_.conveyor(),
                     isometry(snapshot_.bodies(body).body_in_world()).translation());
  }
  [[nodiscard]] bool has_gears(int body) const {
    const CellView view(cell_, snapshot_);
    return std::ranges::any_of(view.slots(), [&](const SlotView& slot) {
      return slot.tray == cell_.bodies(body).name() && !slot.gear.empty();
    });
  }
  /// Whether everything on the belt stays on it.
  [[nodiscard]] bool keeps_all(double distance) const {
    const double end = cell_.conveyor().length_m() / 2 - kEdge_m;
    for (int i = 0; i < cell_.bodies_size(); ++i) {
      if (cell_.bodies(i).has_tray() && on_belt(i) && std::abs(along(i) + distance) > end)
        return false;
    }
    return true;
  }

  const v1::CellDescription& cell_;
  const v1::Snapshot& snapshot_;
  Eigen::Isometry3d X_CW_;
};

/// Sets direction and speed of the belt at rest, and returns its state. The installation decides
/// which value of the direction register means forward, so this reads the state and inverts the
/// register if needed.
Outcome<v1::ConveyorState> set_drive(DemoCell& cell, ConveyorConnection& conveyor, bool forward,
                                     double speed_m_s) {
  const double speed = std::min(speed_m_s, cell.description.conveyor().max_speed_m_s());
  const auto count = static_cast<std::uint16_t>(std::lround(speed / kMetresPerSecondPerCount));
  if (auto done = conveyor.write(modbus::kSpeedRegister, count); !done) {
    return tl::unexpected(done.error());
  }
  for (const bool one : {forward, !forward}) {
    if (auto done = conveyor.write(modbus::kDirectionRegister, one ? 1 : 0); !done) {
      return tl::unexpected(done.error());
    }
    const auto snapshot = cell.connection.snapshot();
    if (!snapshot) return tl::unexpected(snapshot.error());
    if (snapshot->conveyor().forward() == forward) return snapshot->conveyor();
  }
  return failed(FailureKind::kCheck, "the belt did not accept its direction");
}

/// Commands the belt to stop, also after an interruption, and waits until it is at rest.
Outcome<void> stop_belt(DemoCell& cell, ConveyorConnection& conveyor) {
  const interruption::Cleanup cleanup;
  if (auto told = conveyor.write(modbus::kRunRegister, 0); !told) return told;
  const auto stands = cell.wait_until(
      [](const v1::Snapshot& snapshot) {
        return !snapshot.conveyor().run() && snapshot.conveyor().speed_m_s() == 0;
      },
      kStandstillTimeout);
  if (!stands) return tl::unexpected(stands.error());
  return *stands ? Outcome<void>()
                 : failed(FailureKind::kTimeout, "the belt did not stop as commanded");
}

/// Starts the belt, waits until it has run the distance, and stops it.
Outcome<void> run_belt(DemoCell& cell, const Endpoints& endpoints, double distance_m,
                       double speed_m_s) {
  auto conveyor = ConveyorConnection::connect(endpoints);
  if (!conveyor) return tl::unexpected(conveyor.error());
  const auto drive = set_drive(cell, *conveyor, distance_m > 0, speed_m_s);
  if (!drive) return tl::unexpected(drive.error());

  const double speed = drive->speed_setting_m_s();
  const double accel = cell.description.conveyor().max_accel_m_s2();
  const double braking = accel > 0 ? speed * speed / (2 * accel) : 0;
  if (interruption::requested()) return failed(FailureKind::kInterrupted, "interrupted");
  Outcome<bool> arrived = false;
  // A lost reply does not mean that the belt is at rest.
  const auto started = conveyor->write(modbus::kRunRegister, 1);
  if (started) {
    arrived = cell.wait_until(
        [&](const v1::Snapshot& snapshot) {
          const double run = std::abs(snapshot.conveyor().travel_m() - drive->travel_m());
          return run >= std::abs(distance_m) - braking;
        },
        kBeltTimeout);
  }
  const auto stopped = stop_belt(cell, *conveyor);
  if (interruption::happened()) {
    return failed(FailureKind::kInterrupted,
                  stopped ? "interrupted; the belt has stopped"
                          : "interrupted; the belt MAY STILL RUN: " + stopped.error().message);
  }
  if (!started) return started;
  if (!stopped) return stopped;
  if (!arrived) return tl::unexpected(arrived.error());
  return *arrived ? Outcome<void>()
                  : failed(FailureKind::kTimeout, "the belt did not run as commanded");
}

}  // namespace

Outcome<std::string> bring_tray(DemoCell& cell, const Endpoints& endpoints,
                                const std::string& robot) {
  const auto& robots = cell.description.robots();
  const auto found = std::ranges::find(robots, robot, &v1::RobotDescription::name);
  if (!cell.description.has_conveyor() || found == robots.end()) return std::string();
  const auto before = cell.connection.snapshot();
  if (!before) return tl::unexpected(before.error());
  const BeltView view(cell.description, *before);
  const auto plan = view.plan(view.along(isometry(found->base_in_world()).translation()));
  if (!plan) {
    cell.report("belt", "nothing_to_bring", "no tray on it has to be moved", {});
    return std::string();
  }
  const std::string tray = cell.description.bodies(plan->body).name();
  cell.report("belt", "brings",
              fmt::format("brings {} before the {}, {:.0f} mm {}", tray, robot,
                          1e3 * std::abs(plan->distance_m),
                          plan->distance_m > 0 ? "forward" : "in reverse"),
              {{"tray", tray}, {"to", robot}, {"distance_m", plan->distance_m}});
  BoundedPace pace(cell.connection);
  if (auto done = pace.bound(kPace); !done) return tl::unexpected(done.error());
  double travel = 0, moved = 0;
  for (int run = 0; run < kRuns; ++run) {
    const double rest = plan->distance_m - travel;
    if (std::abs(rest) < kOff_m) break;
    if (auto done = run_belt(cell, endpoints, rest, run == 0 ? kSpeed_m_s : kCreep_m_s); !done) {
      return tl::unexpected(done.error());
    }
    const auto after = cell.connection.snapshot();
    if (!after) return tl::unexpected(after.error());
    moved = BeltView(cell.description, *after).along(plan->body) - view.along(plan->body);
    travel = after->conveyor().travel_m() - before->conveyor().travel_m();
  }
  cell.report("belt", "stopped",
              fmt::format("ran {:.1f} mm and stopped, {} came along by {:.1f} mm", 1e3 * travel,
                          tray, 1e3 * moved),
              {{"tray", tray}, {"travel_m", travel}, {"tray_m", moved}});
  if (std::abs(moved - travel) > kMaxBeltSlip_m) {
    return failed(FailureKind::kCheck, fmt::format("{} slipped on the belt by {:.1f} mm", tray,
                                                   1e3 * std::abs(moved - travel)));
  }
  if (std::abs(travel - plan->distance_m) >= kOff_m) {
    return failed(FailureKind::kCheck, fmt::format("the belt stopped {:.0f} mm off its target",
                                                   1e3 * std::abs(travel - plan->distance_m)));
  }
  return tray;
}

}  // namespace aprsim::client
