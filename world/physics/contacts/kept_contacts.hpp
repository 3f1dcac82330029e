#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "world/physics/bodies/free_body.hpp"
#include "world/physics/collision/shapes/contact.hpp"

namespace aprsim::physics {

/// Contacts from one step to the next: those of two bodies that hardly move against each other are
/// carried along with them, and found anew only when one has moved (persistent manifolds, as Bullet
/// and Jolt keep them, but over much shorter ways). A part of what a world's later steps depend on.
/// No call allocates after warm-up.
class KeptContacts {
 public:
  /// What a body may have moved while its contacts are only carried along [m]: they are deeper or
  /// shallower by their part of it, and what is new is by no more than that too deep.
  static constexpr double kMoved = 1e-7;

  /// A body on another that is free, or on a fixed shape.
  struct Pair {
    BodyIndex a = kGround;
    int on = 0;  ///< the other body, or -1 - index of the fixed shape
    const FreeBody* body_a = nullptr;
    const FreeBody* body_b = nullptr;  ///< null for a fixed shape
  };

  explicit KeptContacts(std::size_t bodies) : newest_(bodies, -1) {}

  /// What the last step had no use for is forgotten.
  void begin_step() { ++step_; }
  /// Appends the contacts of a pair; false if they are to be found.
  [[nodiscard]] bool append(const Pair& pair, std::vector<Contact>& out);
  /// Takes what has been found of a pair, from `first` on.
  void keep(const Pair& pair, const std::vector<Contact>& out, std::size_t first);

  /// In b's frame.
  struct Point {
    Eigen::Vector3d p_B = Eigen::Vector3d::Zero(), n_B = Eigen::Vector3d::UnitZ();
    Eigen::Vector3d p_A = Eigen::Vector3d::Zero();  ///< the same in a's frame
    double depth_m = 0;
    SurfacePair pair = SurfacePair::kRobotAny;

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [p_B, n_B, p_A, depth_m, pair] = self;
      io(p_B, n_B, p_A, depth_m, pair);
    }
  };
  /// Contacts of a pair as they were found with a at X_BA.
  struct Manifold {
    BodyIndex a = kGround;
    int on = 0;  ///< see Pair
    Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
    std::vector<Point> points;

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [a, on, X_BA, points] = self;
      io(a, on, X_BA, points);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.index(In::kFreeBody, a);
      if (on >= 0) {
        in.index(In::kFreeBody, on);
      } else {
        in.index(In::kFixed, -1 - on);
      }
    }
  };
  using State = std::vector<Manifold>;
  /// Those of the last step, ordered by pair.
  [[nodiscard]] State save() const;
  /// Those of bodies that there are not are left out.
  void restore(const State& state);

 private:
  struct Kept {
    Manifold manifold;
    std::uint64_t used = 0;  // in which step
    int older = -1;          // of the same body
  };
  [[nodiscard]] bool is_fresh(const Kept& kept) const { return kept.used + 1 >= step_; }
  [[nodiscard]] Kept* find(BodyIndex a, int on);
  [[nodiscard]] Kept& place_for(BodyIndex a, int on);

  std::vector<Kept> kept_;
  std::vector<int> newest_;  // by body a
  std::uint64_t step_ = 1;
};

}  // namespace aprsim::physics
