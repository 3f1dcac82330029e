// A device that fails in each way that an extension can, when its scene says so.

#include <aprsim/device.hpp>
#include <cmath>
#include <stdexcept>
#include <string>

namespace {

using namespace aprsim::device;

class Trouble final : public Device {
 public:
  explicit Trouble(Setup& setup)
      : kind_(setup.text("kind")),
        at_step_(setup.number_or("at_step", 0, 0, 1e9)),
        steps_(setup.signal("steps")) {
    if (kind_ == "constructor") throw std::runtime_error("no licence");
  }

  void step(const Cell& cell, const State& state, Commands& commands) const override {
    state[steps_] += 1;
    if (static_cast<double>(cell.step) < at_step_) return;
    if (kind_ == "throw") throw std::runtime_error("broken \x1b[31m\xff wire");
    if (kind_ == "throw_other") throw 7;
    if (kind_ == "nan") state[steps_] = std::nan("");
    if (kind_ == "index") state[1000] = 1;
    if (kind_ == "no_body") commands.remove(1000);
    if (kind_ == "infinite_force") commands.push(0, {HUGE_VAL, 0, 0});
    if (kind_ == "bad_pose") commands.place(0, {{0, 0, 0}, 2, 0, 0, 0});
    if (kind_ == "many") {
      for (int i = 0; i < 1000; ++i) commands.push(0, {});
    }
    if (kind_ == "push_then_throw") {
      commands.push(0, {100, 0, 0});
      throw std::runtime_error("too late");
    }
  }

 private:
  std::string kind_;
  double at_step_;
  std::size_t steps_;
};

}  // namespace

APRSIM_EXTENSION(Trouble)
