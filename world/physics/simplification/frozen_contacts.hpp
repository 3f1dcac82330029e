#pragma once

#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/bodies/contact_constraint.hpp"

namespace aprsim::physics {

/// A contact that is not solved, in the frame of its first body, with which it moves.
struct FrozenContact {
  int owner = -1;  ///< a merged body or a sleeping group
  BodyIndex a = kGround, b = kGround;
  int fixed = -1;                                 ///< index of the fixed shape when b is kGround
  Eigen::Vector3d p_A = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d f_A = Eigen::Vector3d::Zero();  ///< its last force, on a [N]

  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [owner, a, b, fixed, p_A, f_A] = self;
    io(owner, a, b, fixed, p_A, f_A);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.index(In::kFreeBody, owner, a);
    in.index_or_none(In::kBody, b);
    in.index_or_none(In::kFixed, fixed);
    in.require(b != kGround || fixed >= 0, "a contact with nothing");
  }
};

/// Contacts that contact simplification has taken out of the solver, with their last forces. A
/// value: copied with the state.
class FrozenContacts {
 public:
  void reserve(std::size_t count) { all_.reserve(count); }

  /// Adds a contact solved in this step; `X_WA` and `p_W` are those at its end.
  void add(int owner, const ContactConstraint& constraint, const Eigen::Isometry3d& X_WA,
           const Eigen::Vector3d& p_W);
  /// Removes the contacts of an owner.
  void remove(int owner);
  /// Before a step's contacts are frozen: settled() are then those frozen so far. Contacts frozen
  /// later are also among the solved contacts of that step.
  void settle();

  [[nodiscard]] std::span<const FrozenContact> settled() const { return {all_.data(), settled_}; }
  [[nodiscard]] int count() const { return static_cast<int>(all_.size()); }
  /// Another number whenever settled() has changed.
  [[nodiscard]] std::uint64_t version() const { return version_; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [all, settled, version] = self;
    io(all, settled, version);
    io.require(settled <= all.size(), "more settled contacts than there are");
  }

 private:
  std::vector<FrozenContact> all_;
  std::size_t settled_ = 0;
  std::uint64_t version_ = 0;
};

}  // namespace aprsim::physics
