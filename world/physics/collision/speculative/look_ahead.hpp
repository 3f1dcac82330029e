#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/collision/shapes/contact.hpp"

/// Contacts that will be made within the coming step, so that what is fast is stopped at a surface
/// and not inside or behind it (speculative contacts: Catto, "Continuous Collision", GDC 2013).
namespace aprsim::physics {

/// How far bodies are looked ahead [steps]: one end that is struck makes the other faster, by less
/// than twice.
inline constexpr double kStepsAhead = 2;

/// Where a body's way is longer, contacts are looked for anew after a blow (BlowSearch) [m in a
/// step].
inline constexpr double kStrikingWay = 1e-4;

/// How many steps two bodies are looked ahead that have such a way against each other in one: fewer
/// where it is so long that one of the two has a striking way, yet a little more than the step.
inline constexpr double kLeastAhead = 1.05;
[[nodiscard]] inline double steps_ahead(double way_m) {
  constexpr double kAhead = kStepsAhead * 2 * kStrikingWay;
  return way_m > 0 ? std::clamp(kAhead / way_m, kLeastAhead, kStepsAhead) : kStepsAhead;
}

/// How a rigid body moves, told at one of its points.
struct Moving {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero(), omega_W = Eigen::Vector3d::Zero();
  double reach_m = 0;  ///< of the body from that point
  [[nodiscard]] Eigen::Vector3d velocity_at(const Eigen::Vector3d& q_W) const {
    return v_W + omega_W.cross(q_W - p_W);
  }
};

/// A body's way in some steps, seen from another body.
struct Way {
  Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_W = Eigen::Vector3d::Zero();  ///< of the centre
  Eigen::Vector3d turn_W = Eigen::Vector3d::Zero();   ///< about it [rad]
  double reach_m = 0;
  double steps = 1;

  [[nodiscard]] double turned_m() const { return reach_m * turn_W.norm(); }
  /// At most, of any of its points.
  [[nodiscard]] double longest_m() const { return shift_W.norm() + turned_m(); }
  /// As many times as long.
  [[nodiscard]] Way over(double times) const {
    return {centre_W, times * shift_W, times * turn_W, reach_m, times * steps};
  }
  /// Displacement after a share of it.
  [[nodiscard]] Eigen::Isometry3d at(double share) const {
    Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
    const double angle = turn_W.norm();
    if (angle > 0) out.linear() = Eigen::AngleAxisd(share * angle, turn_W / angle).matrix();
    out.translation() = centre_W + share * shift_W - out.linear() * centre_W;
    return out;
  }
};

/// In a step, without forces between the two.
[[nodiscard]] inline Way way_of(const Moving& body, const Moving& other, double step_s) {
  return {.centre_W = body.p_W,
          .shift_W = step_s * (body.v_W - other.velocity_at(body.p_W)),
          .turn_W = step_s * (body.omega_W - other.omega_W),
          .reach_m = body.reach_m};
}

inline constexpr double kSameSide = 0.9;  ///< cosine between normals

/// Beside a contact of the same two bodies: does one that has been found elsewhere on the way stand
/// for the same touch, or lead right through?
[[nodiscard]] inline bool is_unwanted(const Contact& contact, const Contact& known) {
  constexpr double kSamePlace = 2e-3;  // [m]
  if (leads_through(contact.depth_m, contact.n_W, known.depth_m, known.n_W)) return true;
  return (known.p_W - contact.p_W).squaredNorm() < kSamePlace * kSamePlace &&
         known.n_W.dot(contact.n_W) > kSameSide;
}

/// Contacts of two bodies where they are now: takes those from `first` on.
class StuckContacts {
 public:
  StuckContacts(std::vector<Contact>& found, std::size_t first)
      : count_(std::min(found.size() - first, contacts_.size())) {
    std::copy_n(found.begin() + static_cast<std::ptrdiff_t>(first), count_, contacts_.begin());
    found.resize(first);
  }
  /// Is one of them about as deep, to the same side?
  [[nodiscard]] bool has(const Contact& contact) const {
    const auto end = contacts_.begin() + static_cast<std::ptrdiff_t>(count_);
    return std::any_of(contacts_.begin(), end, [&](const Contact& other) {
      return other.n_W.dot(contact.n_W) > kSameSide && 2 * other.depth_m > contact.depth_m;
    });
  }

 private:
  std::array<Contact, 16> contacts_;
  std::size_t count_;
};

/// The search of find_ahead() for one pair.
template <class Generate>
class SweptContacts {
 public:
  SweptContacts(const Way& way, double gap_m, std::vector<Contact>& out, const Generate& generate)
      : way_(way), gap_m_(gap_m), out_(out), generate_(generate), first_(out.size()) {}

  void find() {
    if (longest_m_ < gap_m_) return;
    if (longest_m_ == 0) return generate_(Eigen::Isometry3d::Identity());
    sweep();
    look_beside_blow();
  }

 private:
  /// Along the way, in strides.
  void sweep() {
    constexpr double kStride = 8.2e-4, kTurnedStride = 4.1e-4, kHardlyTurned = 1e-5;  // [m]
    constexpr int kMostStrides = 64;
    const double parts = std::max(longest_m_ / kStride, way_.turned_m() / kTurnedStride);
    const int strides = std::clamp(static_cast<int>(std::ceil(parts)), 1, kMostStrides);
    const double middle = 0.5 / way_.steps;
    if (way_.turned_m() > kHardlyTurned && middle * strides < 1 && middle * longest_m_ > gap_m_) {
      look(way_.at(middle), middle * way_.shift_W, 0);
    }
    for (int k = 1; k <= strides; ++k) {
      const double share = static_cast<double>(k) / strides;
      if (share * longest_m_ < gap_m_) continue;
      look(way_.at(share), share * way_.shift_W, k > 1 ? 2 * longest_m_ / strides : 0);
    }
  }

  /// A body that strikes at some speed turns about the contact: finds what comes down beside it.
  void look_beside_blow() {
    constexpr double kBlow = 1e-4, kStraightBlow = 1e-3, kOpen = 1e-6, kFarthestBeside = 1e-3;
    if (longest_m_ < (way_.turned_m() > 0 ? kBlow : kStraightBlow)) return;
    const auto struck = std::find_if(
        at(first_), out_.end(), [](const Contact& contact) { return contact.depth_m < -kOpen; });
    if (struck == out_.end()) return;
    const double beside = std::min(longest_m_ / way_.steps, kFarthestBeside);
    const Eigen::Vector3d n_W = struck->n_W, down = -beside * n_W;
    const std::size_t known = out_.size();
    look(Eigen::Isometry3d(Eigen::Translation3d(down)), down, beside);
    out_.erase(std::remove_if(at(known), out_.end(),
                              [&](const Contact& other) { return other.n_W.dot(n_W) < kSameSide; }),
               out_.end());
  }

  /// Contacts of the body displaced by D, which has gone `shift_W`. `just_made_m`: how deep those
  /// are at most that have been made since the last look, 0 = this is the first.
  void look(const Eigen::Isometry3d& D, const Eigen::Vector3d& shift_W, double just_made_m) {
    constexpr double kDeepNow = 1e-4;  // [m]
    const std::size_t known = out_.size();
    generate_(D);
    if (out_.size() == known) return;
    const Eigen::Isometry3d back = D.inverse();
    std::optional<Contact> entered;
    std::size_t kept = known;
    for (std::size_t i = known; i < out_.size(); ++i) {
      Contact contact = out_[i];
      const Eigen::Vector3d p_now = back * contact.p_W;
      const double depth_now = contact.depth_m + (contact.p_W - p_now).dot(contact.n_W);
      const bool late = just_made_m > 0 && (contact.depth_m > just_made_m || depth_now > 0);
      contact.depth_m = depth_now;
      contact.p_W -= shift_W;
      if (!late && depth_now > kDeepNow && !is_stuck(contact)) {
        if (!entered || depth_now < entered->depth_m) entered = contact;
      } else if (!late && is_wanted(contact, known)) {
        out_[kept++] = contact;
      }
    }
    out_.resize(kept);
    if (!entered || out_.size() > first_) return;
    entered->depth_m = 0;
    out_.push_back(*entered);
  }

  /// Beside those that were known before the look.
  [[nodiscard]] bool is_wanted(const Contact& contact, std::size_t known) const {
    return std::none_of(at(first_), at(known),
                        [&contact](const Contact& other) { return is_unwanted(contact, other); });
  }

  /// Contacts where the body is now are looked for when they are asked for.
  [[nodiscard]] bool is_stuck(const Contact& contact) {
    if (!stuck_) {
      const std::size_t known = out_.size();
      generate_(Eigen::Isometry3d::Identity());
      stuck_.emplace(out_, known);
    }
    return stuck_->has(contact);
  }

  [[nodiscard]] std::vector<Contact>::iterator at(std::size_t i) const {
    return out_.begin() + static_cast<std::ptrdiff_t>(i);
  }

  const Way& way_;
  double gap_m_;
  std::vector<Contact>& out_;
  const Generate& generate_;
  std::size_t first_;
  double longest_m_ = way_.longest_m();
  std::optional<StuckContacts> stuck_;
};

/// Appends the contacts that `generate(D)` finds for a body displaced by D, with present depths and
/// the places as seen from its centre: gaps that will close have negative depths. A long way is
/// covered in strides, because a body that is deep inside has contacts of another side. A contact
/// counts where it is made, and once. A turning body is first looked at half a step ahead, unless
/// its way is long. There a contact lies where it acts in the mean over the step, so that rolling
/// and turning neither gain nor lose energy (midpoint rule). A deep contact counts if the body has
/// it at its present pose as well. Otherwise it is another exit from something entered on the way:
/// it counts as just touched, and only without a contact beside it. A body that strikes at some
/// speed turns about the contact; the last look finds what comes down beside it. `gap_m`: least
/// present distance of the two; nothing is searched on the way across it.
template <class Generate>
void find_ahead(const Way& way, double gap_m, std::vector<Contact>& out, const Generate& generate) {
  SweptContacts(way, gap_m, out, generate).find();
}

}  // namespace aprsim::physics
