#pragma once

#include <memory>
#include <span>

#include "world/api/values/pose.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// Trays and gears of a scene on its belt, in whichever engine.
class TraySimulation {
 public:
  virtual ~TraySimulation() = default;
  /// One step of the scene's step size; the belt's speed at its end.
  virtual void step(double belt_speed_m_s) = 0;
  /// Poses of body frames as in the scene; bodies are numbered trays first, then gears.
  [[nodiscard]] virtual Pose body(int index) const = 0;
  [[nodiscard]] virtual int contact_count() const = 0;
};

/// Our own physics, in the scene's mode of contact simplification. The scene must outlive it.
std::unique_ptr<TraySimulation> own_simulation(const scene::Scene& scene);

}  // namespace aprsim::bench
