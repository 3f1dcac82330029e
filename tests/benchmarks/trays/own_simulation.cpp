#include "tests/benchmarks/trays/tray_simulation.hpp"
#include "world/physics/physics_world.hpp"

namespace aprsim::bench {
namespace {

class OwnSimulation : public TraySimulation {
 public:
  explicit OwnSimulation(const scene::Scene& scene) : world_(scene, {}, {}) {}

  void step(double belt_speed_m_s) override {
    world_.set_belt_speed(belt_speed_m_s);
    world_.step();
  }
  [[nodiscard]] Pose body(int index) const override {
    const auto state = world_.body(index);
    return {state.p_WB, state.q_WB};
  }
  [[nodiscard]] int contact_count() const override { return world_.contact_count(); }

 private:
  physics::PhysicsWorld world_;
};

}  // namespace

std::unique_ptr<TraySimulation> own_simulation(const scene::Scene& scene) {
  return std::make_unique<OwnSimulation>(scene);
}

}  // namespace aprsim::bench
