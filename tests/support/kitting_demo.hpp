#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "tests/support/shuttle.hpp"
#include "world/cell/world.hpp"

namespace aprsim::test {

/// A command and the step count at which it was applied.
struct TimedCommand {
  std::uint64_t step = 0;
  api::Ticket ticket = 0;
  std::variant<api::RobotCommand, api::ConveyorCommand> command;
};

/// Applies a command as it was applied when it was recorded.
void apply(world::World& world, const TimedCommand& command);

/// The default cell at work, for as long as wanted: both robots carry gears between trays and kits,
/// and after each trip the belt carries its trays a bit and back. In stepped time.
class KittingDemo {
 public:
  /// The world must outlive the demo, and must be of the scene "aprs".
  explicit KittingDemo(world::World& world, bool belt = true);

  /// Gives the commands that are due, then advances by one step. Throws std::runtime_error when a
  /// robot reports an error or loses its gear.
  void advance();
  /// The same in two parts, for those who time the step itself.
  void command();
  void observe();

  [[nodiscard]] const api::Snapshot& now() const { return now_; }
  [[nodiscard]] int trips() const { return shuttles_[0].trips() + shuttles_[1].trips(); }
  /// Both robots have a gear between their fingers.
  [[nodiscard]] bool both_gripping() const {
    return shuttles_[0].gripping() && shuttles_[1].gripping();
  }
  /// Everything that was applied so far.
  [[nodiscard]] const std::vector<TimedCommand>& commands() const { return commands_; }

 private:
  void send(std::variant<api::RobotCommand, api::ConveyorCommand> command);
  void lead(std::size_t robot);
  void lead_belt();

  world::World* world_;
  bool belt_;
  std::vector<Shuttle> shuttles_;
  std::vector<bool> arrived_;
  std::vector<api::Ticket> tickets_;
  enum class Phase { kPicking, kBeltRuns, kBeltStops };
  Phase phase_ = Phase::kPicking;
  bool forward_ = false;
  double belt_from_m_ = 0;
  api::Ticket ticket_ = 0;
  api::Snapshot now_;
  std::vector<TimedCommand> commands_;
};

}  // namespace aprsim::test
