#pragma once

#include <string>
#include <vector>

#include "world/scene/model/scene.hpp"

namespace aprsim::physics {

/// Numbers of a scene's materials, and how pairs of them act on each other.
class MaterialTable {
 public:
  /// Materials of what is no part or fixture.
  enum Usual : int { kGear, kTray, kFixed, kBelt, kRobot, kUsual };

  struct Surfaces {
    double friction = 0, restitution = 0, rolling_m = 0, spinning_m = 0;
  };

  explicit MaterialTable(const scene::Scene& scene);

  [[nodiscard]] int number_of(const std::string& material) const;
  [[nodiscard]] const Surfaces& between(int a, int b) const {
    return pairs_[static_cast<std::size_t>(a) * names_.size() + static_cast<std::size_t>(b)];
  }

 private:
  std::vector<std::string> names_;
  std::vector<Surfaces> pairs_;
};

}  // namespace aprsim::physics
