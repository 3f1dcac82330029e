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

/// What `generate(D)` appends for a body that is displaced by D, with the depths of now and the
/// places as seen from its centre: gaps that will close have negative depths. A long way is gone in
/// strides, for what is deep inside has contacts of another side: a contact counts where it is
/// made, and once. The first look at what turns is half a step ahead, where that is no long way:
/// there a contact lies where it acts in the mean over the step, so that rolling and turning
/// neither gain nor lose energy (midpoint rule). What would be deep already must be found where the
/// body is now as well: else it is another way out of what is entered on the way, and counts, as
/// just touched, only where there is none beside it. What strikes at some speed turns about the
/// place: the last look is at what that brings down beside it. `gap_m`: so far apart the two are
/// now at least; nothing is looked for on the way across it.
template <class Generate>
void find_ahead(const Way& way, double gap_m, std::vector<Contact>& out, const Generate& generate) {
  constexpr double kStride = 8.2e-4, kTurnedStride = 4.1e-4;  // [m]
  constexpr double kHardlyTurned = 1e-5, kDeepNow = 1e-4;     // [m]
  constexpr double kBlow = 1e-4, kStraightBlow = 1e-3, kOpen = 1e-6, kFarthestBeside = 1e-3;
  constexpr int kMostStrides = 64;
  const std::size_t first = out.size();
  const double longest = way.longest_m();
  if (longest < gap_m) return;
  if (longest == 0) return generate(Eigen::Isometry3d::Identity());
  std::optional<StuckContacts> stuck;
  const auto is_stuck = [&](const Contact& contact) {
    if (!stuck) {
      const std::size_t known = out.size();
      generate(Eigen::Isometry3d::Identity());
      stuck.emplace(out, known);
    }
    return stuck->has(contact);
  };
  const auto look = [&](const Eigen::Isometry3d& D, const Eigen::Vector3d& shift_W,
                        double just_made) {
    const std::size_t known = out.size();
    generate(D);
    if (out.size() == known) return;
    const Eigen::Isometry3d back = D.inverse();
    std::optional<Contact> entered;
    std::size_t kept = known;
    for (std::size_t i = known; i < out.size(); ++i) {
      Contact contact = out[i];
      const Eigen::Vector3d p_now = back * contact.p_W;
      const double depth_now = contact.depth_m + (contact.p_W - p_now).dot(contact.n_W);
      const bool late = just_made > 0 && (contact.depth_m > just_made || depth_now > 0);
      contact.depth_m = depth_now;
      contact.p_W -= shift_W;
      if (!late && depth_now > kDeepNow && !is_stuck(contact)) {
        if (!entered || depth_now < entered->depth_m) entered = contact;
        continue;
      }
      const auto unwanted = [&](const Contact& other) { return is_unwanted(contact, other); };
      const auto begin = out.begin() + static_cast<std::ptrdiff_t>(first);
      const auto end = out.begin() + static_cast<std::ptrdiff_t>(known);
      if (!late && std::none_of(begin, end, unwanted)) out[kept++] = contact;
    }
    out.resize(kept);
    if (!entered || out.size() > first) return;
    entered->depth_m = 0;
    out.push_back(*entered);
  };
  const double parts = std::max(longest / kStride, way.turned_m() / kTurnedStride);
  const int strides = std::clamp(static_cast<int>(std::ceil(parts)), 1, kMostStrides);
  const double middle = 0.5 / way.steps;
  if (way.turned_m() > kHardlyTurned && middle * strides < 1 && middle * longest > gap_m) {
    look(way.at(middle), middle * way.shift_W, 0);
  }
  for (int k = 1; k <= strides; ++k) {
    const double share = static_cast<double>(k) / strides;
    if (share * longest < gap_m) continue;
    look(way.at(share), share * way.shift_W, k > 1 ? 2 * longest / strides : 0);
  }
  if (longest < (way.turned_m() > 0 ? kBlow : kStraightBlow)) return;
  const auto struck = std::find_if(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
                                   [](const Contact& contact) { return contact.depth_m < -kOpen; });
  if (struck == out.end()) return;
  const double beside = std::min(longest / way.steps, kFarthestBeside);
  const Eigen::Vector3d n_W = struck->n_W, down = -beside * n_W;
  const auto known = out.end() - out.begin();
  look(Eigen::Isometry3d(Eigen::Translation3d(down)), down, beside);
  out.erase(std::remove_if(out.begin() + known, out.end(),
                           [&](const Contact& other) { return other.n_W.dot(n_W) < kSameSide; }),
            out.end());
}

}  // namespace aprsim::physics
