// A device that does each of the commands once, and counts and remembers.

#include <aprsim/device.hpp>
#include <string>
#include <vector>

namespace {

using namespace aprsim::device;

class Mover final : public Device {
 public:
  explicit Mover(Setup& setup)
      : action_(setup.text("action")),
        at_step_(setup.number_or("at_step", 0, 0, 1e9)),
        until_step_(setup.number_or("until_step", at_step_ + 1, 0, 1e9)),
        amount_(setup.number_or("amount", 0, -1e6, 1e6)),
        once_(setup.flag_or("once", false)),
        done_(setup.signal("done")),
        seed_(setup.memory(12345)),
        noise_(setup.signal("noise")) {
    if (action_ == "gripper" || action_ == "stop_robot") thing_ = setup.robot("robot");
    if (action_ == "push" || action_ == "turn" || action_ == "place" || action_ == "remove") {
      thing_ = setup.body("body");
    }
  }

  void step(const Cell& cell, const State& state, Commands& commands) const override {
    // A generator whose state is saved with the cell (Numerical Recipes' LCG modulo 2^32).
    state[seed_] = next(state[seed_]);
    state[noise_] = state[seed_] / 4294967296.0;
    const auto step = static_cast<double>(cell.step);
    if (step < at_step_ || step >= until_step_ || (once_ && state[done_] > 0)) return;
    state[done_] += 1;
    act(cell, commands);
  }

 private:
  static double next(double seed) {
    return static_cast<double>(static_cast<std::uint32_t>(seed) * 1664525U + 1013904223U);
  }

  void act(const Cell& cell, Commands& commands) const {
    if (action_ == "run_belt") commands.run_belt(amount_);
    if (action_ == "stop_belt") commands.stop_belt();
    if (action_ == "gripper") commands.set_gripper(thing_, amount_);
    if (action_ == "stop_robot") commands.stop_robot(thing_);
    if (action_ == "push") commands.push(thing_, {amount_, 0, 0});
    if (action_ == "turn") commands.push(thing_, {}, {0, 0, amount_});
    if (action_ == "remove") commands.remove(thing_);
    if (action_ != "place") return;
    Pose pose = cell.bodies[thing_].pose;
    pose.position.x += amount_;
    commands.place(thing_, pose);
  }

  std::string action_;
  double at_step_, until_step_, amount_;
  bool once_;
  std::size_t done_, seed_, noise_;
  std::size_t thing_ = 0;
};

}  // namespace

APRSIM_EXTENSION(Mover)
