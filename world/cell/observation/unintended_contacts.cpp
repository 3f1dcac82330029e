#include "world/cell/observation/unintended_contacts.hpp"

#include <algorithm>
#include <memory>
#include <vector>

namespace aprsim::world {
namespace {

using TouchSide = api::ContactSide;
using Bodies = std::span<const scene::FreeBody>;

/// A gear or part, which grippers are for.
bool is_workpiece(const TouchSide& side, Bodies bodies) {
  return side.kind == TouchSide::Kind::kBody &&
         !bodies[static_cast<std::size_t>(side.index)].is_tray();
}

bool is_work(const physics::ArmForce& force, int robot, bool has_tool, Bodies bodies) {
  // Suction of a cup, or contacts of the gear in the gripper.
  if (force.relayed || (force.on_gripper && force.part < 0)) return true;
  if (force.on_gripper && (!has_tool || is_workpiece(force.partner, bodies))) return true;
  // A contact of two arms counts once, for the first one.
  return force.partner.kind == TouchSide::Kind::kRobot && force.partner.index <= robot;
}

}  // namespace

void UnintendedContacts::add(std::uint64_t step, int robot,
                             std::span<const physics::ArmForce> forces, bool has_tool,
                             Bodies bodies) {
  std::vector<api::UnintendedContact> now;
  for (const physics::ArmForce& force : forces) {
    const double force_n = force.f_W.norm();
    if (force_n <= 0 || is_work(force, robot, has_tool, bodies)) continue;
    const int part = force.on_gripper ? force.part : TouchSide::kFirstLink + force.link;
    const api::UnintendedContact touch{
        {TouchSide::Kind::kRobot, robot, part}, force.partner, step, step, force_n};
    const auto same = std::ranges::find_if(now, [&](const auto& t) { return t.same_pair(touch); });
    if (same == now.end()) {
      now.push_back(touch);
    } else {
      same->max_force_n += force_n;
    }
  }
  if (now.empty()) return;
  auto all = list_ ? *list_ : std::vector<api::UnintendedContact>();
  for (const api::UnintendedContact& touch : now) {
    const auto last = std::find_if(all.rbegin(), all.rend(), [&](const auto& earlier) {
      return earlier.same_pair(touch) && step - earlier.last_step <= kSameContactSteps;
    });
    if (last != all.rend()) {
      last->last_step = step;
      last->max_force_n = std::max(last->max_force_n, touch.max_force_n);
      continue;
    }
    if (all.size() == api::kMaxUnintendedContacts) all.erase(all.begin());
    all.push_back(touch);
  }
  list_ = std::make_shared<const std::vector<api::UnintendedContact>>(std::move(all));
}

void UnintendedContacts::renumber(std::span<const int> new_of) {
  if (!list_) return;
  auto all = *list_;
  for (api::UnintendedContact& touch : all) {
    for (TouchSide* side : {&touch.first, &touch.second}) {
      if (side->kind == TouchSide::Kind::kBody) {
        side->index = new_of[static_cast<std::size_t>(side->index)];
      }
    }
  }
  list_ = std::make_shared<const std::vector<api::UnintendedContact>>(std::move(all));
}

}  // namespace aprsim::world
