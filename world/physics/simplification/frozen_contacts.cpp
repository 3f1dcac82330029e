#include "world/physics/simplification/frozen_contacts.hpp"

namespace aprsim::physics {

void FrozenContacts::add(int owner, const ContactConstraint& constraint,
                         const Eigen::Isometry3d& X_WA, const Eigen::Vector3d& p_W) {
  const Contact& contact = constraint.contact;
  all_.push_back({owner, contact.a, contact.b, constraint.fixed, X_WA.inverse() * p_W,
                  X_WA.linear().transpose() * constraint.f_W});
}

void FrozenContacts::remove(int owner) {
  // Stable removal in place; the boundary of settled contacts moves with it.
  std::size_t kept = 0, settled = 0;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (all_[i].owner == owner) continue;
    if (i < settled_) ++settled;
    all_[kept++] = all_[i];
  }
  if (settled != settled_) ++version_;
  settled_ = settled;
  all_.resize(kept);
}

void FrozenContacts::settle() {
  if (settled_ == all_.size()) return;
  settled_ = all_.size();
  ++version_;
}

}  // namespace aprsim::physics
