// A scale: weighs what lies in a box of the world, and stops the belt when it has its load.

#include <aprsim/device.hpp>
#include <cmath>
#include <limits>

namespace {

using namespace aprsim::device;

constexpr double kNone = std::numeric_limits<double>::infinity();

class Scale final : public Device {
 public:
  explicit Scale(Setup& setup)
      : low_(setup.vector("low_m")),
        high_(setup.vector("high_m")),
        settling_s_(setup.number_or("settling_s", 0.1, 0.001, 60)),
        full_kg_(setup.number_or("full_kg", kNone, 0, kNone)),
        mass_(setup.signal("mass_kg")),
        full_(setup.signal("full")) {}

  void step(const Cell& cell, const State& state, Commands& commands) const override {
    double load_kg = 0;
    for (const Body& body : cell.bodies) {
      if (!body.lost && weighs(body.pose.position)) load_kg += body.mass_kg;
    }
    // The reading follows the load with a lag of first order.
    state[mass_] += (load_kg - state[mass_]) * (1 - std::exp(-cell.step_s / settling_s_));
    const bool full = state[mass_] >= full_kg_;
    if (full && state[full_] == 0 && cell.belt != nullptr) commands.stop_belt();
    state[full_] = full ? 1 : 0;
  }

 private:
  bool weighs(const Vector3& p) const {
    return p.x >= low_.x && p.x <= high_.x && p.y >= low_.y && p.y <= high_.y && p.z >= low_.z &&
           p.z <= high_.z;
  }

  Vector3 low_, high_;
  double settling_s_, full_kg_;
  std::size_t mass_, full_;
};

}  // namespace

APRSIM_EXTENSION(Scale)
