#include "world/physics/simplification.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::physics {
namespace {

constexpr int kPairSteps = 20;        // at relative rest before a joint is made
constexpr int kParkSteps = 50;        // at rest on the carrier before an island is parked
constexpr double kParkShare = 0.1;    // of e1, e2: parking is stricter than joining
constexpr double kBeltMargin = 2e-3;  // [m] from the belt's end

}  // namespace

Simplification::Simplification(const scene::Physics& physics, std::span<FreeBody> bodies,
                               const FixedShapes& fixed, dWorldID world)
    : active_(physics.simplification != scene::Simplification::kOff),
      parks_(physics.simplification == scene::Simplification::kDormant),
      speed_(physics.simplify_speed_m_s),
      accel_(physics.simplify_accel_m_s2),
      force_(physics.simplify_force_n),
      bodies_(bodies),
      fixed_(&fixed),
      records_(bodies.size()),
      islands_(bodies.size()),
      groups_(bodies.size()) {
  if (!active_) return;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].is_tray()) continue;
    // One joint a gear, made once: attached and enabled only while it is needed.
    records_[i].joint.reset(dJointCreateFixed(world, nullptr));
    dJointDisable(records_[i].joint.get());
  }
}

bool Simplification::riding(int body) const {
  return parked(body) && groups_[static_cast<std::size_t>(at(body).group)].on_belt &&
         belt_speed_ != 0;
}

bool Simplification::resting(int body) const {
  return parked(body) || at(body).tray >= 0 || at(body).quiet_steps >= kPairSteps;
}

api::GroupKind Simplification::group_kind(int body) const {
  if (parked(body)) return api::GroupKind::kDormant;
  return group(body) >= 0 ? api::GroupKind::kJoined : api::GroupKind::kNone;
}

int Simplification::group(int body) const {
  const int tray = bodies_[static_cast<std::size_t>(body)].is_tray() ? body : at(body).tray;
  for (std::size_t i = 0; i < records_.size(); ++i) {
    const auto& record = records_[i];
    if (parked(body) && record.group == at(body).group) return static_cast<int>(i);
    if (!parked(body) && tray >= 0 && record.tray == tray) return tray;
  }
  return -1;
}

int Simplification::joint_count() const {
  int count = 0;
  for (std::size_t i = 0; i < records_.size(); ++i) {
    const auto& record = records_[i];
    // A parked body hangs on its carrier as if by one joint, a joined gear on its tray.
    if (record.tray >= 0 || record.group >= 0) ++count;
  }
  return count;
}

Eigen::Vector3d Simplification::carrier_velocity(bool on_belt) const {
  return on_belt ? (belt_speed_ * fixed_->belt_axis_W).eval() : Eigen::Vector3d::Zero();
}

bool Simplification::leaves_belt(double belt_min, double belt_max) const {
  const double end = 0.5 * fixed_->belt_length_m - kBeltMargin;
  return (belt_speed_ > 0 && belt_max > end) || (belt_speed_ < 0 && belt_min < -end);
}

// ---- waking

void Simplification::wake(int body, std::vector<int>& woken) {
  const int group = at(body).group;
  if (group < 0) return;
  const Eigen::Vector3d v = carrier_velocity(groups_[static_cast<std::size_t>(group)].on_belt);
  for (std::size_t i = 0; i < records_.size(); ++i) {
    auto& record = records_[i];
    if (record.group != group) continue;
    record.group = -1;
    record.quiet_steps = 0;
    record.v_before = v;
    record.omega_before.setZero();
    auto& free = bodies_[i];
    free.v_com_W = v;
    ode::set_velocity(free.body.get(), v, Eigen::Vector3d::Zero());
    if (record.tray >= 0) dJointEnable(record.joint.get());
    woken.push_back(static_cast<int>(i));
  }
  groups_[static_cast<std::size_t>(group)].used = false;
}

void Simplification::touched_by_robot(int body) {
  if (!active_) return;
  at(body).touched = true;
  if (bodies_[static_cast<std::size_t>(body)].is_tray()) {
    for (std::size_t i = 0; i < records_.size(); ++i) {
      if (records_[i].tray == body) release(static_cast<int>(i));
    }
  } else if (at(body).tray >= 0) {
    release(body);
  }
}

void Simplification::release(int gear) {
  auto& record = at(gear);
  dJointAttach(record.joint.get(), nullptr, nullptr);
  dJointDisable(record.joint.get());
  record.tray = -1;
  record.pair_steps = 0;
}

void Simplification::join(int gear, int tray) {
  auto& record = at(gear);
  dJointID joint = record.joint.get();
  dJointAttach(joint, bodies_[static_cast<std::size_t>(gear)].body.get(),
               bodies_[static_cast<std::size_t>(tray)].body.get());
  dJointSetFixed(joint);
  dJointSetFeedback(joint, &record.feedback);
  dJointEnable(joint);
  record.tray = tray;
  record.contact_force = record.pair_force;
  ode::copy(record.contact_force, record.feedback.f1);
}

// ---- riding the belt

void Simplification::begin_step(double belt_speed_m_s, std::vector<int>& woken) {
  for (auto& record : records_) record.touched = false;
  const bool changed = belt_speed_m_s != belt_speed_;
  for (std::size_t i = 0; i < records_.size(); ++i) {
    const int group = records_[i].group;
    if (group < 0) continue;
    const auto& what = groups_[static_cast<std::size_t>(group)];
    if (!what.on_belt) continue;
    // Woken at the old speed: what the belt does next, friction has to pass on.
    if (changed || leaves_belt(what.belt_min, what.belt_max)) wake(static_cast<int>(i), woken);
  }
  belt_speed_ = belt_speed_m_s;
}

void Simplification::ride(double step_s) {
  if (belt_speed_ == 0) return;
  const double shift = belt_speed_ * step_s;
  for (auto& group : groups_) {
    if (!group.used || !group.on_belt) continue;
    group.belt_min += shift;
    group.belt_max += shift;
  }
  for (std::size_t i = 0; i < records_.size(); ++i) {
    if (!riding(static_cast<int>(i))) continue;
    auto& free = bodies_[i];
    const Eigen::Vector3d step = shift * fixed_->belt_axis_W;
    free.X_WB.translation() += step;
    free.bounds.min += step;
    free.bounds.max += step;
    ode::set_position(free.body.get(), free.com_W());
  }
}

// ---- after a step

void Simplification::observe(std::span<const Touch> touches, std::span<const int> island_of,
                             double step_s) {
  ride(step_s);
  if (active_) {
    note_pairs(touches);
    judge_joints();
    judge_pairs(step_s);
  }
  judge_islands(touches, island_of, step_s);
  for (std::size_t i = 0; i < records_.size(); ++i) {
    records_[i].v_before = bodies_[i].v_com_W;
    records_[i].omega_before = bodies_[i].omega_W;
  }
}

void Simplification::note_pairs(std::span<const Touch> touches) {
  for (auto& record : records_) {
    record.pair_tray = -1;
    record.other_contact = false;
    record.pair_force.setZero();
  }
  const int count = static_cast<int>(records_.size());
  for (const auto& touch : touches) {
    const int a = touch.contact.a, b = touch.contact.b;
    const bool pair = touch.contact.pair == SurfacePair::kGearTray && a < count && b < count;
    if (pair && (at(a).pair_tray < 0 || at(a).pair_tray == b)) {
      at(a).pair_tray = b;
      at(a).pair_force += touch.f_W;
      continue;
    }
    if (a >= 0 && a < count) at(a).other_contact = true;
    if (b >= 0 && b < count) at(b).other_contact = true;
  }
}

/// Algorithm 2: the joint goes when the force it transmits is no longer the contact force that it
/// replaced.
void Simplification::judge_joints() {
  for (std::size_t i = 0; i < records_.size(); ++i) {
    const auto& record = records_[i];
    if (record.tray < 0 || record.group >= 0) continue;
    const Eigen::Vector3d transmitted = ode::vector(record.feedback.f1);
    if ((record.contact_force - transmitted).norm() > force_) release(static_cast<int>(i));
  }
}

/// Algorithm 1, with the conditions held for some steps so that a turning point is no rest.
void Simplification::judge_pairs(double step_s) {
  for (std::size_t i = 0; i < records_.size(); ++i) {
    auto& record = records_[i];
    if (bodies_[i].is_tray() || record.tray >= 0 || record.group >= 0) continue;
    const int tray = record.pair_tray;
    if (tray < 0 || record.touched || record.other_contact || at(tray).touched) {
      record.pair_steps = 0;
      continue;
    }
    const auto& gear = bodies_[i];
    const auto& carrier = bodies_[static_cast<std::size_t>(tray)];
    const Eigen::Vector3d lever = gear.com_W() - carrier.com_W();
    const auto relative = [&lever](const Eigen::Vector3d& v, const Eigen::Vector3d& v_carrier,
                                   const Eigen::Vector3d& omega_carrier) {
      return (v - v_carrier - omega_carrier.cross(lever)).eval();
    };
    const Eigen::Vector3d v = relative(gear.v_com_W, carrier.v_com_W, carrier.omega_W);
    const Eigen::Vector3d v_before =
        relative(record.v_before, at(tray).v_before, at(tray).omega_before);
    const Eigen::Vector3d spin = gear.omega_W - carrier.omega_W;
    const bool rests = v.norm() < speed_ && (v - v_before).norm() < accel_ * step_s &&
                       spin.norm() * gear.radius_m < speed_;
    record.pair_steps = rests ? record.pair_steps + 1 : 0;
    if (record.pair_steps >= kPairSteps) join(static_cast<int>(i), tray);
  }
}

void Simplification::judge_islands(std::span<const Touch> touches, std::span<const int> island_of,
                                   double step_s) {
  for (auto& island : islands_) island = {};
  const int count = static_cast<int>(records_.size());
  for (const auto& touch : touches) {
    if (touch.fixed < 0 || touch.contact.a >= count) continue;
    const int number = island_of[static_cast<std::size_t>(touch.contact.a)];
    if (number < 0) continue;
    auto& island = islands_[static_cast<std::size_t>(number)];
    if (!touch.belt) {
      island.on_fixed = true;
      continue;
    }
    const double x = (fixed_->X_CW * touch.contact.p_W).x();
    island.on_belt = true;
    island.belt_min = std::min(island.belt_min, x);
    island.belt_max = std::max(island.belt_max, x);
  }
  for (int i = 0; i < count; ++i) {
    auto& record = at(i);
    if (record.group >= 0) continue;
    const int number = island_of[static_cast<std::size_t>(i)];
    if (number < 0) {
      record.quiet_steps = 0;
      continue;
    }
    auto& island = islands_[static_cast<std::size_t>(number)];
    const auto& free = bodies_[static_cast<std::size_t>(i)];
    const Eigen::Vector3d v = free.v_com_W - carrier_velocity(island.on_belt);
    const double limit = kParkShare * speed_;
    const bool rests = v.norm() < limit && free.omega_W.norm() * free.radius_m < limit &&
                       (free.v_com_W - record.v_before).norm() < kParkShare * accel_ * step_s;
    record.quiet_steps = rests && !record.touched ? record.quiet_steps + 1 : 0;
    if (record.quiet_steps < kParkSteps) island.all_quiet = false;
  }
  if (!parks_) return;
  for (int number = 0; number < count; ++number) {
    const auto& island = islands_[static_cast<std::size_t>(number)];
    const bool carried = island.on_fixed != island.on_belt || (island.on_fixed && belt_speed_ == 0);
    if (!carried || !island.all_quiet) continue;
    if (island.on_belt && leaves_belt(island.belt_min, island.belt_max)) continue;
    park(number, island_of);
  }
}

void Simplification::park(int island, std::span<const int> island_of) {
  const auto free_group =
      std::find_if(groups_.begin(), groups_.end(), [](const Group& group) { return !group.used; });
  const auto& what = islands_[static_cast<std::size_t>(island)];
  *free_group = {true, what.on_belt, what.belt_min, what.belt_max};
  const int group = static_cast<int>(free_group - groups_.begin());
  for (std::size_t i = 0; i < records_.size(); ++i) {
    if (island_of[i] != island || records_[i].group >= 0) continue;
    records_[i].group = group;
    auto& free = bodies_[i];
    free.v_com_W = carrier_velocity(what.on_belt);
    free.omega_W.setZero();
    ode::set_velocity(free.body.get(), free.v_com_W, free.omega_W);
    if (records_[i].tray >= 0) dJointDisable(records_[i].joint.get());
  }
}

}  // namespace aprsim::physics
