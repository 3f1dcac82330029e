#include "world/cell/robot_touches.hpp"

#include <algorithm>
#include <memory>
#include <vector>

namespace aprsim::world {
namespace {

using TouchSide = api::ContactSide;

bool is_gear(const TouchSide& side, const api::CellDescription& cell) {
  return side.kind == TouchSide::Kind::kBody &&
         cell.bodies[static_cast<std::size_t>(side.index)].kind == api::BodyKind::kGear;
}

bool is_work(const physics::ArmForce& force, int robot, bool has_tool,
             const api::CellDescription& cell) {
  // What a cup draws, or what a gear in the gripper meets.
  if (force.relayed || (force.on_gripper && force.part < 0)) return true;
  if (force.on_gripper && (!has_tool || is_gear(force.partner, cell))) return true;
  // Of two arms, the first one's.
  return force.partner.kind == TouchSide::Kind::kRobot && force.partner.index <= robot;
}

}  // namespace

void RobotTouches::add(std::uint64_t step, int robot, std::span<const physics::ArmForce> forces,
                       bool has_tool, const api::CellDescription& cell) {
  std::vector<api::RobotTouch> now;
  for (const physics::ArmForce& force : forces) {
    const double force_n = force.f_W.norm();
    if (force_n <= 0 || is_work(force, robot, has_tool, cell)) continue;
    const int part = force.on_gripper ? force.part : TouchSide::kFirstLink + force.link;
    const api::RobotTouch touch{
        {TouchSide::Kind::kRobot, robot, part}, force.partner, step, step, force_n};
    const auto same = std::ranges::find_if(now, [&](const auto& t) { return t.same_pair(touch); });
    if (same == now.end()) {
      now.push_back(touch);
    } else {
      same->greatest_n += force_n;
    }
  }
  if (now.empty()) return;
  auto all = list_ ? *list_ : std::vector<api::RobotTouch>();
  for (const api::RobotTouch& touch : now) {
    const auto last = std::find_if(all.rbegin(), all.rend(), [&](const auto& earlier) {
      return earlier.same_pair(touch) && step - earlier.last_step <= kSameTouch;
    });
    if (last != all.rend()) {
      last->last_step = step;
      last->greatest_n = std::max(last->greatest_n, touch.greatest_n);
      continue;
    }
    if (all.size() == api::kMaxRobotTouches) all.erase(all.begin());
    all.push_back(touch);
  }
  list_ = std::make_shared<const std::vector<api::RobotTouch>>(std::move(all));
}

void RobotTouches::renumber(std::span<const int> new_of) {
  if (!list_) return;
  auto all = *list_;
  for (api::RobotTouch& touch : all) {
    for (TouchSide* side : {&touch.first, &touch.second}) {
      if (side->kind == TouchSide::Kind::kBody) {
        side->index = new_of[static_cast<std::size_t>(side->index)];
      }
    }
  }
  list_ = std::make_shared<const std::vector<api::RobotTouch>>(std::move(all));
}

}  // namespace aprsim::world
