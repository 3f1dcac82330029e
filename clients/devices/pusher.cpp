// A pusher: pushes what lies in a box of the world with the force that a client sets.

#include <aprsim/device.hpp>

namespace {

using namespace aprsim::device;

class Pusher final : public Device {
 public:
  explicit Pusher(Setup& setup)
      : low_(setup.vector("low_m")),
        high_(setup.vector("high_m")),
        along_(setup.vector("along")),
        force_(setup.input("force_n", 0, 0, setup.number("max_force_n", 0, 1000), "N")),
        pushed_(setup.signal("pushed")) {}

  void step(const Cell& cell, const State& state, Commands& commands) const override {
    const double force_n = state[force_];
    state[pushed_] = 0;
    for (std::size_t i = 0; force_n > 0 && i < cell.bodies.size(); ++i) {
      const Body& body = cell.bodies[i];
      if (body.lost || !reaches(body.pose.position)) continue;
      commands.push(i, {along_.x * force_n, along_.y * force_n, along_.z * force_n});
      state[pushed_] += 1;
    }
  }

 private:
  bool reaches(const Vector3& p) const {
    return p.x >= low_.x && p.x <= high_.x && p.y >= low_.y && p.y <= high_.y && p.z >= low_.z &&
           p.z <= high_.z;
  }

  Vector3 low_, high_, along_;
  std::size_t force_, pushed_;
};

}  // namespace

APRSIM_EXTENSION(Pusher)
