#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/collision/shapes/contact.hpp"

/// Raw contact points of one pair and their reduction. Internal to contact generation.
namespace aprsim::physics::detail {

/// A contact point in the working frame of the pair; n points into the first object.
struct Candidate {
  Eigen::Vector3d p, n;
  double depth;
};

/// Fixed-capacity list. A full list replaces its shallowest point, so that the deepest one stays.
class Candidates {
 public:
  static constexpr int kCapacity = 64;

  /// Adds the point when it penetrates; ignores it otherwise.
  void add(const Eigen::Vector3d& p, const Eigen::Vector3d& n, double depth) {
    if (!(depth > 0)) return;
    if (size_ < kCapacity) {
      items_[static_cast<std::size_t>(size_++)] = {p, n, depth};
    } else {
      replace_shallowest({p, n, depth});
    }
  }
  void add_all(const Candidates& others) {
    for (int i = 0; i < others.size(); ++i) add(others[i].p, others[i].n, others[i].depth);
  }
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] const Candidate& operator[](int i) const {
    return items_[static_cast<std::size_t>(i)];
  }

 private:
  void replace_shallowest(const Candidate& c);

  std::array<Candidate, kCapacity> items_;
  int size_ = 0;
};

/// Destination of the contacts of a pair: the bodies, the frame S, and the list.
struct Emission {
  const Eigen::Isometry3d& X_WS;
  BodyIndex a, b;
  SurfacePair pair;
  std::vector<Contact>& out;
  bool flip = false;  ///< the candidates' normals point into b
  bool many = false;  ///< up to eight points of one plane, for faces that are no rectangles
};

/// Appends at most four of the candidates (see Emission::many): the deepest, then those farthest
/// from what is chosen.
void emit_reduced(const Candidates& candidates, const Emission& to);

/// The same for a gear with axis u (in S): at most four whose normal is along the axis ("flat":
/// shoulder, floor, end faces) and at most four others ("wall").
void emit_reduced_by_axis(const Candidates& candidates, const Eigen::Vector3d& u,
                          const Emission& to);

/// The same for walls of several directions: of each direction at most four (see Emission::many).
void emit_reduced_by_direction(const Candidates& candidates, const Emission& to);

}  // namespace aprsim::physics::detail
