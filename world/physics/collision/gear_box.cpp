#include "world/physics/collision/gear_vs_prism.hpp"
#include "world/physics/collision/narrow_phase.hpp"

namespace aprsim::physics {

void gear_box(const scene::GearType& gear, const Eigen::Isometry3d& X_WG,
              const Eigen::Vector3d& size, const Eigen::Isometry3d& X_WS, BodyIndex a, BodyIndex b,
              SurfacePair pair, std::vector<Contact>& out) {
  const Eigen::Isometry3d X_SG = X_WS.inverse(Eigen::Isometry) * X_WG;
  const detail::GearShape shape = detail::gear_shape(gear);
  detail::Candidates points;
  const detail::Prism box = detail::box_prism(-0.5 * size, 0.5 * size);
  if (!detail::gear_on_prism(shape, X_SG, box, {}, points)) return;
  detail::emit_reduced_by_axis(points, X_SG.linear().col(2), {X_WS, a, b, pair, out});
}

}  // namespace aprsim::physics
