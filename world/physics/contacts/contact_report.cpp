#include "world/physics/contacts/contact_report.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace aprsim::physics {
namespace {

using Side = api::ContactSide;

constexpr std::size_t kForceCapacity = 256;  // of an arm
constexpr std::size_t kListCapacity = 1024;  // contacts to reserve for

}  // namespace

ContactReport::ContactReport(const PhysicsModel& model)
    : model_(model), forces_(model.arms.size()) {
  for (auto& list : forces_) list.reserve(kForceCapacity);
  frozen_.reserve(kListCapacity);
  all_.reserve(kListCapacity);
  for (auto* list : {&keys_, &last_keys_, &order_}) list->reserve(kListCapacity);
}

void ContactReport::begin_step() {
  fresh_ = false;
  for (auto& list : forces_) list.clear();
}

void ContactReport::add_substep(double share) {
  if (forces_.empty()) return;
  // Impulse of the substep over the full step: the mean force that joint torques and force sensors
  // see.
  for (const auto& constraint : model_.constraints) add_arm_forces(constraint, share);
  for (std::size_t r = 0; r < forces_.size(); ++r) add_suction(r, share);
}

void ContactReport::end_step(ArmPenalty& penalty) { penalty.find(forces_); }

/// Reaction of a cup's suction on its robot.
void ContactReport::add_suction(std::size_t robot, double share) {
  const GripperMechanism& gripper = model_.grippers[robot];
  const Suction suction = gripper.suction();
  if (suction.force_n <= 0) return;
  const Eigen::Isometry3d X_WLip = gripper.parts().X_WT();
  ArmForce force;
  force.link = model_.arms[robot].links() - 1;
  force.p_W = X_WLip.translation();
  // Reaction of the vacuum force on the cup, along the approach.
  force.f_W = share * suction.force_n * X_WLip.linear().col(2);
  force.partner = suction.body >= 0 ? side(suction.body, -1) : Side{};
  force.on_gripper = true;
  forces_[robot].push_back(force);
}

/// Adds the contact to each arm that has it: at the flange if it is with the gripper, else at the
/// link. Forces between parts of one gripper are internal.
void ContactReport::add_arm_forces(const ContactConstraint& constraint, double share) {
  const auto& contact = constraint.contact;
  const Eigen::Vector3d f_W = share * constraint.f_W;
  for (std::size_t r = 0; r < forces_.size(); ++r) {
    const int robot = static_cast<int>(r);
    const bool a = of_gripper(robot, contact.a), b = of_gripper(robot, contact.b);
    const int flange = model_.arms[r].links() - 1;
    const auto on_gripper = [&](const Eigen::Vector3d& on_it_W, int part, BodyIndex other,
                                int fixed, bool relayed) {
      forces_[r].push_back({.link = flange,
                            .p_W = contact.p_W,
                            .f_W = on_it_W,
                            .partner = side(other, fixed),
                            .partner_link = link(other),
                            .on_gripper = true,
                            .part = part,
                            .relayed = relayed});
    };
    const BodyIds& ids = model_.ids;
    if (a && !b) {
      on_gripper(f_W, ids.part_of(contact.a), contact.b, constraint.fixed, false);
    }
    if (b && !a) on_gripper(-f_W, ids.part_of(contact.b), contact.a, -1, false);
    // Contacts of a held body are listed for observers, but load the arm only through the grip.
    const int held = model_.grippers[r].state().held_body;
    if (held >= 0 && contact.a == held && !b) {
      on_gripper(f_W, -1, contact.b, constraint.fixed, true);
    }
    if (held >= 0 && contact.b == held && !a) on_gripper(-f_W, -1, contact.a, -1, true);
    if (model_.ids.is_link(contact.b) && model_.ids.robot_of(contact.b) == robot) {
      forces_[r].push_back({link(contact.b), contact.p_W, -f_W, side(contact.a, -1)});
    }
  }
}

bool ContactReport::of_gripper(int robot, BodyIndex id) const {
  return model_.ids.is_gripper(id) && model_.ids.robot_of(id) == robot;
}

int ContactReport::link(BodyIndex id) const {
  return model_.ids.is_link(id) ? model_.ids.link_of(id) : -1;
}

Side ContactReport::side(BodyIndex id, int fixed) const {
  const BodyIds& ids = model_.ids;
  if (id < 0) {
    // Pieces of one fixture are one thing.
    return {Side::Kind::kFixed,
            fixed < 0 ? fixed : model_.fixed.shapes[static_cast<std::size_t>(fixed)].first};
  }
  if (ids.is_part(id)) return {Side::Kind::kBody, id};
  if (ids.is_free(id)) return {Side::Kind::kTool, ids.tool_of(id)};
  const int part = ids.is_link(id) ? Side::kFirstLink + ids.link_of(id) : ids.part_of(id);
  return {Side::Kind::kRobot, ids.robot_of(id), part};
}

void ContactReport::restore(const State& state) {
  forces_ = state;
  frozen_known_ = false;
  fresh_ = false;
}

void ContactReport::write(std::vector<api::ContactSnapshot>& out) {
  refresh();
  fresh_ = false;
  out.clear();
  out.reserve(api::kMaxContacts);
  for (const std::uint64_t i : order_) {
    if (out.size() == api::kMaxContacts) return;
    out.push_back(all_[i]);
  }
}

void ContactReport::refresh() {
  if (fresh_) return;
  gather();
  sort();
  fresh_ = true;
}

const ContactPairs& ContactReport::pairs() {
  refresh();
  if (pairs_known_) return pairs_;
  pairs_.all.clear();
  for (const std::uint64_t i : order_) {
    if (!pairs_.all.empty() && pairs_.all.back().key == keys_[i]) continue;
    pairs_.all.push_back({keys_[i], all_[i].first, all_[i].second});
  }
  ++pairs_.version;
  pairs_known_ = true;
  return pairs_;
}

void ContactReport::gather() {
  all_.clear();
  for (const ContactConstraint& constraint : model_.constraints) {
    const Contact& contact = constraint.contact;
    all_.push_back(
        {side(contact.a, -1), side(contact.b, constraint.fixed), contact.p_W, constraint.f_W});
  }
  // Snapshots contain frozen contacts, too: observers cannot tell whether contacts are simplified.
  refresh_frozen();
  all_.insert(all_.end(), frozen_.begin(), frozen_.end());
  for (std::size_t r = 0; r < forces_.size(); ++r) {
    const int robot = static_cast<int>(r);
    for (const ArmForce& force : forces_[r]) {
      if (!force.penalty) continue;
      // Both arms of a pair have the contact in their lists.
      if (force.partner.kind == Side::Kind::kRobot && force.partner.index < robot) continue;
      const Side own{Side::Kind::kRobot, robot, Side::kFirstLink + force.link};
      all_.push_back({own, force.partner, force.p_W, force.f_W});
    }
  }
}

/// The list changes only when bodies fall asleep, wake, merge, unmerge or move with a carrier.
void ContactReport::refresh_frozen() {
  const auto& simplification = model_.simplification;
  // The list is cached. Its key changes whenever a frozen contact may have moved.
  const FrozenKey key{simplification.merged_contacts().version(),
                      simplification.sleeping_contacts().version(),
                      simplification.sleeping().belt_travel_m()};
  const auto awake = simplification.awake();
  const bool moving = std::any_of(awake.begin(), awake.end(), [&](int body) {
    return simplification.composites().parent(body) >= 0;
  });
  if (frozen_known_ && !moving && key == frozen_key_) return;
  frozen_.clear();
  add_frozen(simplification.merged_contacts());
  add_frozen(simplification.sleeping_contacts());
  frozen_key_ = key;
  frozen_known_ = !moving;
}

/// Positions are those at the start of the step, as for all contacts.
void ContactReport::add_frozen(const FrozenContacts& frozen) {
  for (const FrozenContact& contact : frozen.settled()) {
    const Eigen::Isometry3d X_WA = model_.simplification.X_WB(contact.a);
    const FreeBody& body = model_.body(contact.a);
    const Eigen::Vector3d p = X_WA * contact.p_A;
    // All other contacts are reported where the search found them, before the step moved the
    // bodies. Frozen ones are shifted back by one step to match.
    const Eigen::Vector3d v =
        model_.simplification.velocity(contact.a) + body.omega_W.cross(p - X_WA * body.mass.com);
    frozen_.push_back({side(contact.a, -1), side(contact.b, contact.fixed), p - model_.step_s * v,
                       X_WA.linear() * contact.f_A});
  }
}

/// Sorts by first side, then by second side, robots first; contacts of one pair keep their order.
/// Sorting is skipped if the list of keys has not changed.
void ContactReport::sort() {
  const auto code = [](const Side& side) {
    const std::uint64_t rank = side.kind == Side::Kind::kRobot  ? 0
                               : side.kind == Side::Kind::kBody ? 1
                               : side.kind == Side::Kind::kTool ? 2
                                                                : 3;
    // 26 bits per side, so that a pair fits into one 64-bit key.
    return rank << 24 | static_cast<std::uint64_t>(side.index) << 8 |
           static_cast<std::uint64_t>(side.part + 1);
  };
  keys_.clear();
  for (const auto& contact : all_)
    keys_.push_back(code(contact.first) << 26 | code(contact.second));
  // Contact lists rarely change between steps; comparing keys is cheaper than sorting.
  if (keys_ == last_keys_) return;
  pairs_known_ = false;
  last_keys_ = keys_;
  order_.resize(keys_.size());
  std::iota(order_.begin(), order_.end(), 0u);
  std::sort(order_.begin(), order_.end(), [this](std::uint64_t i, std::uint64_t k) {
    return std::pair(keys_[i], i) < std::pair(keys_[k], k);
  });
}

}  // namespace aprsim::physics
