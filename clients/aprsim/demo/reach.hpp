#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "clients/aprsim/demo/cell_view.hpp"

namespace aprsim::client {

/// A position that a robot refused.
struct Refusal {
  SlotView place;
  bool too_far = false;  ///< rather than, for example, at a joint limit
};

/// Places that a robot was found not to reach. It turns about its base, so a place farther out at
/// the height of an unreachable one is unreachable, too.
class Reach {
 public:
  explicit Reach(const Eigen::Vector3d& p_WB) : p_WB_(p_WB) {}

  void exclude(const Refusal& refusal) { refusals_.push_back(refusal); }
  [[nodiscard]] bool excludes(const SlotView& place) const;

 private:
  [[nodiscard]] double distance(const SlotView& place) const;

  Eigen::Vector3d p_WB_;
  std::vector<Refusal> refusals_;
};

}  // namespace aprsim::client
