#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "world/physics/bodies/free_body.hpp"
#include "world/physics/collision/shapes/contact.hpp"

namespace aprsim::physics {

/// Cache of contact manifolds from one step to the next (persistent manifolds, as in Bullet and
/// Jolt, but over much shorter distances). Contacts of two bodies move with them, and are detected
/// again once the relative motion exceeds kReuseDistance. Later steps depend on it, so it is part
/// of the saved state. No call allocates after warm-up.
class ContactCache {
 public:
  /// Relative motion since detection up to which contacts are reused [m]. It bounds the error of
  /// their depth, and the depth of a new contact that is missed.
  static constexpr double kReuseDistance = 1e-7;

  /// A free body on another free body or on a fixed shape.
  struct Pair {
    BodyIndex a = kGround;
    int on = 0;  ///< the other body, or -1 - index of the fixed shape
    const FreeBody* body_a = nullptr;
    const FreeBody* body_b = nullptr;  ///< null for a fixed shape
  };

  explicit ContactCache(std::size_t bodies) : newest_(bodies, -1) {}

  /// Entries that the last step did not use become free.
  void begin_step() { ++step_; }
  /// Appends the cached contacts of a pair; false if they must be detected.
  [[nodiscard]] bool append(const Pair& pair, std::vector<Contact>& out);
  /// Stores the contacts of a pair, from `first` on.
  void store(const Pair& pair, const std::vector<Contact>& out, std::size_t first);

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
  /// The manifolds of the last step, ordered by pair.
  [[nodiscard]] State save() const;
  /// Ignores manifolds of bodies that do not exist.
  void restore(const State& state);

 private:
  struct Entry {
    Manifold manifold;
    std::uint64_t used = 0;  // in which step
    int older = -1;          // of the same body
  };
  [[nodiscard]] bool is_fresh(const Entry& entry) const { return entry.used + 1 >= step_; }
  [[nodiscard]] Entry* find(BodyIndex a, int on);
  [[nodiscard]] Entry& slot_for(BodyIndex a, int on);

  std::vector<Entry> entries_;
  std::vector<int> newest_;  // by body a
  std::uint64_t step_ = 1;
};

}  // namespace aprsim::physics
