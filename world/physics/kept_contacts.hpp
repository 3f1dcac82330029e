#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "world/physics/bodies/free_body.hpp"
#include "world/physics/collision/contact.hpp"

namespace aprsim::physics {

/// Contacts of gears in trays from one step to the next: those of a gear that hardly moves in its
/// tray are carried along with both, and found anew only when it has moved (persistent manifolds,
/// as Bullet and Jolt keep them, but for much shorter ways). A part of what a world's later steps
/// depend on. No call allocates after warm-up.
class KeptContacts {
 public:
  /// What a gear may have moved in its tray while its contacts are only carried along [m]: they are
  /// deeper or shallower by their part of it, and what is new is by no more than that too deep.
  static constexpr double kMoved = 1e-7;

  explicit KeptContacts(std::size_t bodies) : manifolds_(bodies) {}

  /// What the last step had no use for is forgotten.
  void begin_step() { ++step_; }
  /// Appends the contacts of a gear and a tray, by their numbers; false if they are to be found.
  [[nodiscard]] bool append(BodyIndex gear, const FreeBody& of_gear, BodyIndex tray,
                            const FreeBody& of_tray, std::vector<Contact>& out);
  /// Takes what has been found of them, from `first` on.
  void keep(BodyIndex gear, const FreeBody& of_gear, BodyIndex tray, const FreeBody& of_tray,
            const std::vector<Contact>& out, std::size_t first);

  /// In the tray's frame.
  struct Point {
    Eigen::Vector3d p_T, n_T;
    Eigen::Vector3d p_G;  ///< the same in the gear's frame
    double depth_m = 0;

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [p_T, n_T, p_G, depth_m] = self;
      io(p_T, n_T, p_G, depth_m);
    }
  };
  /// Contacts of a gear with one tray, as they were found with the gear at X_TG.
  struct Manifold {
    BodyIndex gear = -1, tray = -1;
    Eigen::Isometry3d X_TG = Eigen::Isometry3d::Identity();
    std::vector<Point> points;

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [gear, tray, X_TG, points] = self;
      io(gear, tray, X_TG, points);
    }
  };
  using State = std::vector<Manifold>;
  [[nodiscard]] State save() const;
  void restore(const State& state);

 private:
  struct OfGear {
    Manifold manifold;
    std::uint64_t used = 0;  // in which step; 0 = never
  };
  std::vector<OfGear> manifolds_;  // by gear: with the tray of which it was found last
  std::uint64_t step_ = 1;
};

}  // namespace aprsim::physics
