#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/collision/shapes/contact.hpp"

/// Speculative contacts (Catto, "Continuous Collision", GDC 2013): contacts of the coming step are
/// detected along the predicted motion. Fast bodies then stop at a surface, not inside or behind
/// it.
namespace aprsim::physics {

/// Prediction horizon of slow bodies [steps]. An impact at one end of a body speeds up its other
/// end, by less than a factor of two.
inline constexpr double kLookaheadSteps = 2;

/// Displacement in a step [m] from which a body may impact: contacts are then searched again after
/// the solve (ImpactRecheck).
inline constexpr double kImpactDisplacement = 1e-4;

/// Shortest prediction horizon [steps], of fast bodies: a little more than the step.
inline constexpr double kMinLookaheadSteps = 1.05;
/// Prediction horizon of two bodies with this relative displacement in a step. It is shorter where
/// one of them may impact, since ImpactRecheck then covers the motion after the impact.
[[nodiscard]] inline double lookahead_steps(double displacement_m) {
  constexpr double kAhead = kLookaheadSteps * 2 * kImpactDisplacement;
  return displacement_m > 0
             ? std::clamp(kAhead / displacement_m, kMinLookaheadSteps, kLookaheadSteps)
             : kLookaheadSteps;
}

/// Velocity of a rigid body, given at the point `p_W`.
struct BodyVelocity {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero(), omega_W = Eigen::Vector3d::Zero();
  double reach_m = 0;  ///< largest distance of the body from that point
  [[nodiscard]] Eigen::Vector3d velocity_at(const Eigen::Vector3d& q_W) const {
    return v_W + omega_W.cross(q_W - p_W);
  }
};

/// Displacement of a body relative to another one over some steps: a translation of its centre and
/// a rotation about it.
struct Displacement {
  Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d translation_W = Eigen::Vector3d::Zero();  ///< of the centre
  Eigen::Vector3d rotation_W = Eigen::Vector3d::Zero();     ///< rotation vector [rad]
  double reach_m = 0;  ///< largest distance of the body from its centre
  double steps = 1;

  /// Upper bounds of the displacement of any point: by the rotation, and by both.
  [[nodiscard]] double max_rotation_m() const { return reach_m * rotation_W.norm(); }
  [[nodiscard]] double max_m() const { return translation_W.norm() + max_rotation_m(); }
  /// The same motion over `factor` times as many steps.
  [[nodiscard]] Displacement scaled(double factor) const {
    return {centre_W, factor * translation_W, factor * rotation_W, reach_m, factor * steps};
  }
  /// Rigid transform in world after a share of the displacement.
  [[nodiscard]] Eigen::Isometry3d at(double share) const {
    Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
    const double angle = rotation_W.norm();
    if (angle > 0) out.linear() = Eigen::AngleAxisd(share * angle, rotation_W / angle).matrix();
    out.translation() = centre_W + share * translation_W - out.linear() * centre_W;
    return out;
  }
};

/// Displacement of `body` relative to `other` in a step without forces between them.
[[nodiscard]] inline Displacement relative_displacement(const BodyVelocity& body,
                                                        const BodyVelocity& other, double step_s) {
  return {.centre_W = body.p_W,
          .translation_W = step_s * (body.v_W - other.velocity_at(body.p_W)),
          .rotation_W = step_s * (body.omega_W - other.omega_W),
          .reach_m = body.reach_m};
}

inline constexpr double kSameSide = 0.9;  ///< cosine between normals

/// Whether a contact that was detected elsewhere along the displacement duplicates `known`, a
/// contact of the same two bodies, or is an exit right through the body.
[[nodiscard]] inline bool is_duplicate(const Contact& contact, const Contact& known) {
  constexpr double kSamePlace = 2e-3;  // [m]
  if (is_tunnelling(contact.depth_m, contact.n_W, known.depth_m, known.n_W)) return true;
  return (known.p_W - contact.p_W).squaredNorm() < kSamePlace * kSamePlace &&
         known.n_W.dot(contact.n_W) > kSameSide;
}

/// Contacts of two bodies at their present poses. The constructor moves those from `first` on out
/// of `found`.
class CurrentContacts {
 public:
  CurrentContacts(std::vector<Contact>& found, std::size_t first)
      : count_(std::min(found.size() - first, contacts_.size())) {
    std::copy_n(found.begin() + static_cast<std::ptrdiff_t>(first), count_, contacts_.begin());
    found.resize(first);
  }
  /// Whether one of them has nearly the same normal and at least half of the depth.
  [[nodiscard]] bool has(const Contact& contact) const {
    const auto end = contacts_.begin() + static_cast<std::ptrdiff_t>(count_);
    return std::any_of(contacts_.begin(), end, [&](const Contact& other) {
      return other.n_W.dot(contact.n_W) > kSameSide && 2 * other.depth_m > contact.depth_m;
    });
  }

  /// The one nearest to a place with nearly the same normal; null = none.
  [[nodiscard]] const Contact* nearest(const Eigen::Vector3d& p_W,
                                       const Eigen::Vector3d& n_W) const {
    const Contact* found = nullptr;
    for (std::size_t i = 0; i < count_; ++i) {
      const Contact& other = contacts_[i];
      if (other.n_W.dot(n_W) <= kSameSide) continue;
      if (found == nullptr || (other.p_W - p_W).squaredNorm() < (found->p_W - p_W).squaredNorm()) {
        found = &other;
      }
    }
    return found;
  }

 private:
  std::array<Contact, 16> contacts_;
  std::size_t count_;
};

/// One call of find_speculative_contacts(): the sweep of a pair.
template <class Generate>
class SpeculativeSweep {
 public:
  SpeculativeSweep(const Displacement& displacement, double gap_m, std::vector<Contact>& out,
                   const Generate& generate)
      : displacement_(displacement),
        gap_m_(gap_m),
        out_(out),
        generate_(generate),
        first_(out.size()) {}

  void find() {
    if (max_m_ < gap_m_) return;
    if (max_m_ == 0) return generate_(Eigen::Isometry3d::Identity());
    sweep();
    find_beside_impact();
  }

 private:
  /// Detection at substeps of the displacement, so that a body cannot pass a thin obstacle between
  /// two of them.
  void sweep() {
    constexpr double kSubstep = 8.2e-4, kRotationSubstep = 4.1e-4, kMinRotation = 1e-5;  // [m]
    constexpr int kMaxSubsteps = 64;
    const double parts =
        std::max(max_m_ / kSubstep, displacement_.max_rotation_m() / kRotationSubstep);
    const int substeps = static_cast<int>(std::clamp<double>(std::ceil(parts), 1, kMaxSubsteps));
    // The middle of the coming step. Contacts there act at the mean pose (midpoint rule).
    const double middle = 0.5 / displacement_.steps;
    if (displacement_.max_rotation_m() > kMinRotation && middle * substeps < 1 &&
        middle * max_m_ > gap_m_) {
      detect(displacement_.at(middle), middle * displacement_.translation_W, 0);
    }
    for (int k = 1; k <= substeps; ++k) {
      const double share = static_cast<double>(k) / substeps;
      if (share * max_m_ < gap_m_) continue;
      detect(displacement_.at(share), share * displacement_.translation_W,
             k > 1 ? 2 * max_m_ / substeps : 0);
    }
  }

  /// After an impact a body rotates about the contact. Contacts beside the first one are detected
  /// with the body moved against its normal.
  void find_beside_impact() {
    constexpr double kRotatingImpact = 1e-4, kTranslatingImpact = 1e-3, kOpen = 1e-6,
                     kMaxBeside = 1e-3;
    if (max_m_ < (displacement_.max_rotation_m() > 0 ? kRotatingImpact : kTranslatingImpact))
      return;
    const auto struck = std::find_if(
        at(first_), out_.end(), [](const Contact& contact) { return contact.depth_m < -kOpen; });
    if (struck == out_.end()) return;
    const double beside = std::min(max_m_ / displacement_.steps, kMaxBeside);
    const Eigen::Vector3d n_W = struck->n_W, down = -beside * n_W;
    const std::size_t known = out_.size();
    detect(Eigen::Isometry3d(Eigen::Translation3d(down)), down, beside);
    out_.erase(std::remove_if(at(known), out_.end(),
                              [&](const Contact& other) { return other.n_W.dot(n_W) < kSameSide; }),
               out_.end());
  }

  /// Contacts of the body displaced by D, whose centre has moved by `shift_W`. `max_new_depth_m`:
  /// bound of the depth of contacts that began since the last substep, 0 in the first one.
  void detect(const Eigen::Isometry3d& D, const Eigen::Vector3d& shift_W, double max_new_depth_m) {
    constexpr double kDeepAtPresentPose = 1e-4;  // [m]
    const std::size_t known = out_.size();
    generate_(D);
    if (out_.size() == known) return;
    // Depth and place are carried back to the present pose, where the solver needs them.
    const Eigen::Isometry3d back = D.inverse();
    std::optional<Contact> entered;
    std::size_t kept = known;
    for (std::size_t i = known; i < out_.size(); ++i) {
      Contact contact = out_[i];
      const Eigen::Vector3d p_now = back * contact.p_W;
      const double depth_now = contact.depth_m + (contact.p_W - p_now).dot(contact.n_W);
      // Deeper than the motion since the last substep allows: it is an exit of something entered
      // earlier, and has been detected there.
      const bool late = max_new_depth_m > 0 && (contact.depth_m > max_new_depth_m || depth_now > 0);
      contact.depth_m = depth_now;
      place(contact, shift_W, p_now);
      if (!late && depth_now > kDeepAtPresentPose && !exists_now(contact)) {
        if (!entered || depth_now < entered->depth_m) entered = contact;
      } else if (!late && is_new(contact, known)) {
        out_[kept++] = contact;
      }
    }
    out_.resize(kept);
    if (!entered || out_.size() > first_) return;
    entered->depth_m = 0;
    out_.push_back(*entered);
  }

  /// Places a contact of the displaced body at the present pose: at the place relative to the
  /// body's centre, since a round body rolls on, or at the point of the body, such as a corner. The
  /// contact of the present pose tells which. It is asked for only where the body turns fast; there
  /// the places are so far apart that tops would nod and fall.
  void place(Contact& contact, const Eigen::Vector3d& shift_W, const Eigen::Vector3d& carried_W) {
    constexpr double kFastTurn = 0.02;  // [rad] of a step
    const Eigen::Vector3d rolled_W = contact.p_W - shift_W;
    contact.p_W = rolled_W;
    if (displacement_.rotation_W.norm() < kFastTurn * displacement_.steps) return;
    const Contact* now = current().nearest(carried_W, contact.n_W);
    if (now == nullptr) return;
    contact.carried = (now->p_W - carried_W).squaredNorm() < (now->p_W - rolled_W).squaredNorm();
    if (contact.carried) contact.p_W = carried_W;
  }

  /// Not a duplicate of the contacts before this substep.
  [[nodiscard]] bool is_new(const Contact& contact, std::size_t known) const {
    return std::none_of(at(first_), at(known),
                        [&contact](const Contact& other) { return is_duplicate(contact, other); });
  }

  /// Whether the contact exists at the present pose as well.
  [[nodiscard]] bool exists_now(const Contact& contact) { return current().has(contact); }

  /// Generated on demand, since few sweeps need them.
  [[nodiscard]] const CurrentContacts& current() {
    if (!current_) {
      const std::size_t known = out_.size();
      generate_(Eigen::Isometry3d::Identity());
      current_.emplace(out_, known);
    }
    return *current_;
  }

  [[nodiscard]] std::vector<Contact>::iterator at(std::size_t i) const {
    return out_.begin() + static_cast<std::ptrdiff_t>(i);
  }

  const Displacement& displacement_;
  double gap_m_;
  std::vector<Contact>& out_;
  const Generate& generate_;
  std::size_t first_;
  double max_m_ = displacement_.max_m();
  std::optional<CurrentContacts> current_;
};

/// Appends the contacts that `generate(D)` detects for a body displaced by the rigid transform D.
/// Depths are those of the present pose: a gap that will close has a negative depth. Places are
/// relative to the body's centre, as it is now.
///
/// A large displacement is divided into substeps, because a body deep inside another one has
/// contacts with a wrong side. Each contact is appended once, where it begins. A rotating body is
/// first tested in the middle of the step, unless its displacement is large: there a contact acts
/// in the mean over the step, so that rolling neither gains nor loses energy (midpoint rule).
///
/// A deep contact is appended only if it exists at the present pose as well. Otherwise the
/// shallowest of them is appended with depth 0, if there is no other contact. `gap_m`: a lower
/// bound of the present distance; the sweep begins where it can be closed.
template <class Generate>
void find_speculative_contacts(const Displacement& displacement, double gap_m,
                               std::vector<Contact>& out, const Generate& generate) {
  SpeculativeSweep(displacement, gap_m, out, generate).find();
}

}  // namespace aprsim::physics
