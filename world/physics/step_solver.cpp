#include "world/physics/step_solver.hpp"

#include <algorithm>
#include <tuple>

namespace aprsim::physics {
namespace {

constexpr double kSameContact = 3e-3;  // [m] from where it was in the last step, at most
constexpr double kSameFace = 0.9;      // cosine between its normals then and now
constexpr double kFalling = 0.03;      // [m/s], slower bodies lie on something

/// The least rotation that takes one normal to another; none where they have little in common.
class NormalTurn {
 public:
  NormalTurn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const double cosine = from.dot(to);
    if (cosine < kSameFace) return;
    axis_ = from.cross(to);
    scale_ = 1 / (1 + cosine);
  }
  Eigen::Vector3d operator()(const Eigen::Vector3d& v) const {
    const Eigen::Vector3d across = axis_.cross(v);
    return v + across + scale_ * axis_.cross(across);
  }

 private:
  Eigen::Vector3d axis_ = Eigen::Vector3d::Zero();  // times the angle's sine
  double scale_ = 0;
};

void continue_from(const StepSolver::LastContact& last, ContactConstraint& constraint) {
  const NormalTurn turned(last.n_W, constraint.contact.n_W);
  const auto take = [&turned](const auto& from, auto& to) {
    to = from;
    to.last = turned(from.last);
    to.change = turned(from.change);
  };
  take(last.f_guess_W, constraint.f_guess_W);
  take(last.torque_guess_W, constraint.torque_guess_W);
}

StepSolver::Touching bodies_of(const ContactConstraint& constraint) {
  return {constraint.contact.a, constraint.contact.b, constraint.fixed};
}

}  // namespace

StepSolver::StepSolver(PhysicsModel& model)
    : model_(model),
      islands_(model),
      before_(model.bodies.size()),
      grippers_before_(model.grippers.size()) {
  roots_.reserve(model.bodies.size());
  begun_.reserve(model.bodies.size());
  const std::size_t islands = model.bodies.size() + model.grippers.size();
  stale_.resize(islands, 1);
  first_contact_.resize(islands, -1);
  kept_.reserve(kConstraintCapacity);
  for (auto* of_contacts : {&island_of_, &next_contact_}) of_contacts->reserve(kConstraintCapacity);
  matches_.reserve(4 * kConstraintCapacity);
  for (auto* marks : {&matched_, &continues_}) marks->reserve(kConstraintCapacity);
  for (auto* contacts : {&memory_.contacts, &memory_before_.contacts, &last_contacts_}) {
    contacts->reserve(kConstraintCapacity);
  }
}

void StepSolver::step() {
  islands_.find(model_, model_.constraints);
  std::fill(stale_.begin(), stale_.end(), 1);
  solve_stale(0);
}

void StepSolver::step_again(std::size_t known) {
  if (others_awake()) {
    begin();
    return step();
  }
  islands_.find(model_, model_.constraints);
  std::fill(stale_.begin(), stale_.end(), 0);
  const auto spoil = [this](int island) { stale_[static_cast<std::size_t>(island)] = 1; };
  for (std::size_t i = known; i < model_.constraints.size(); ++i) {
    spoil(islands_.number_of(model_, model_.constraints[i]));
  }
  // What pulls on a gripper has been told again.
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    if (model_.grippers[r].suction().force_n > 0) {
      spoil(islands_.number_of_gripper(static_cast<int>(r)));
    }
  }
  start_anew();
  solve_stale(known);
}

bool StepSolver::others_awake() const { return !std::ranges::equal(begun_, awake_roots()); }

/// What is stale is where the step starts, all else where it has led to.
void StepSolver::start_anew() {
  for (const int root : begun_) {
    dBodyID body = model_.body(root).body.get();
    ode::SavedState& kept = before_[static_cast<std::size_t>(root)];
    const ode::SavedState solved = kept;
    ode::save(body, kept);
    if (!is_stale(islands_.number_of_root(root))) ode::restore(body, solved);
  }
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    const GripperMechanism::Solved solved = grippers_before_[r];
    model_.grippers[r].save(grippers_before_[r]);
    const int island = islands_.number_of_gripper(static_cast<int>(r));
    if (!is_stale(island)) model_.grippers[r].restore(solved);
  }
  // What failed counts, also where it is solved anew.
  std::swap(memory_.failures, memory_before_.failures);
  std::swap(memory_.latest, memory_before_.latest);
}

/// The first `known` contacts have been solved once in this step.
void StepSolver::solve_stale(std::size_t known) {
  list_members();
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < model_.constraints.size(); ++i) {
    if (!is_stale(island_of_[i])) continue;
    ContactConstraint& constraint = model_.constraints[i];
    constraint.f_guess_W = ForceGuess(i < known ? constraint.f_W : zero);
    constraint.torque_guess_W = ForceGuess(i < known ? constraint.torque_W : zero);
    constraint.normal_n = 0;
    constraint.impact_m2_s2 = 0;
  }
  take_last_contacts();
  match_last_contacts(known);
  for (std::size_t i = 0; i < roots_.size(); ++i) {
    const int island = roots_[i].first;
    if ((i == 0 || island != roots_[i - 1].first) && is_stale(island)) solve_island(island);
  }
  // Grippers on their own.
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    const int own = model_.ids.free_count() + static_cast<int>(r);
    const int island = islands_.number_of_gripper(static_cast<int>(r));
    if (island == own && !model_.grippers[r].idle() && is_stale(island)) solve_island(island);
  }
  keep_contacts();
}

/// Roots, ordered by their islands, and each island's contacts in a list.
void StepSolver::list_members() {
  roots_.clear();
  for (const int root : awake_roots()) roots_.emplace_back(islands_.number_of_root(root), root);
  std::sort(roots_.begin(), roots_.end());
  const auto& constraints = model_.constraints;
  island_of_.resize(constraints.size());
  next_contact_.resize(constraints.size());
  std::fill(first_contact_.begin(), first_contact_.end(), -1);
  for (std::size_t i = constraints.size(); i > 0; --i) {
    const int island = islands_.number_of(model_, constraints[i - 1]);
    int& first = first_contact_[static_cast<std::size_t>(island)];
    island_of_[i - 1] = island;
    next_contact_[i - 1] = std::exchange(first, static_cast<int>(i) - 1);
  }
}

void StepSolver::solve_island(int island) {
  system_.begin(model_.step_s, model_.scene.physics.residual_m_s);
  const auto first = std::lower_bound(roots_.begin(), roots_.end(), Member{island, -1});
  for (auto root = first; root != roots_.end() && root->first == island; ++root) {
    system_.add_body(model_.body(root->second).body.get());
  }
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    if (islands_.number_of_gripper(static_cast<int>(r)) != island) continue;
    if (!model_.grippers[r].idle()) model_.grippers[r].add_to(system_);
  }
  if (auto* joints = model_.simplification.virtual_joints()) {
    const auto pairs = joints->pairs();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (islands_.number_of_root(pairs[i].a) == island) joints->add_to(system_, i);
    }
  }
  for (int i = first_contact_[static_cast<std::size_t>(island)]; i >= 0;
       i = next_contact_[static_cast<std::size_t>(i)]) {
    ContactConstraint& constraint = model_.constraints[static_cast<std::size_t>(i)];
    const ContactResponse response = response_of(constraint);
    constraint.impact_m2_s2 = response.unanswered_m2_s2;
    system_.add_contact(constraint, model_.ode_body(constraint.contact.a),
                        model_.ode_body(constraint.contact.b), response);
  }
  note(system_.advance());
}

void StepSolver::note(const ContactSolver::Outcome& outcome) {
  const auto iterations = static_cast<std::uint32_t>(outcome.iterations);
  ++work_.solved;
  work_.iterations += iterations;
  memory_.latest.iterations = std::max(memory_.latest.iterations, iterations);
  memory_.latest.residual_m_s = std::max(memory_.latest.residual_m_s, outcome.residual_m_s);
  if (outcome.converged) return;
  ++memory_.failures.not_converged;
  memory_.failures.worst_m_s = std::max(memory_.failures.worst_m_s, outcome.residual_m_s);
}

/// Puts an arm's link that is touched where it is in this step, and says how the surfaces act.
ContactResponse StepSolver::response_of(const ContactConstraint& constraint) {
  const BodyIndex id = constraint.contact.b;
  ContactSetting setting{.arm_link = model_.ids.is_link(id),
                         .belt_axis_W = model_.fixed.belt_axis_W,
                         .belt_speed_m_s = model_.belt_speed_m_s,
                         .step_s = model_.step_s,
                         .flight_step_s = model_.scene.physics.step_s};
  if (setting.arm_link) {
    const auto robot = static_cast<std::size_t>(model_.ids.robot_of(id));
    model_.arms[robot].place_link(model_.ids.link_of(id), model_.step_s);
  }
  if (constraint.restitution > 0) note_approach(constraint, setting);
  return contact_response(constraint, setting);
}

void StepSolver::note_approach(const ContactConstraint& constraint, ContactSetting& setting) const {
  const Contact& contact = constraint.contact;
  const auto velocity = [&](BodyIndex id) -> Eigen::Vector3d {
    dBodyID body = model_.ode_body(id);
    if (body == nullptr) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d arm = contact.p_W - ode::vector(dBodyGetPosition(body));
    return ode::vector(dBodyGetLinearVel(body)) + ode::vector(dBodyGetAngularVel(body)).cross(arm);
  };
  const Eigen::Vector3d v_a = velocity(contact.a), v_b = velocity(contact.b);
  setting.normal_speed_m_s = (v_a - v_b).dot(contact.n_W);
  // What hardly moves is held up by something.
  const double fall = -model_.scene.physics.gravity_m_s2 * contact.n_W.z();
  const auto falls = [&](BodyIndex id, const Eigen::Vector3d& v) {
    return model_.ids.is_free(id) && v.norm() > kFalling ? fall : 0;
  };
  setting.normal_accel_m_s2 = falls(contact.a, v_a) - falls(contact.b, v_b);
}

// ---- where the search begins

void StepSolver::take_last_contacts() {
  std::swap(last_contacts_, memory_.contacts);
  memory_.contacts.clear();
  begins_at_last_ = true;
}

/// Each contact behind those that are `known` begins with the forces of the nearest one of the same
/// two bodies in the last step, turned as its normal has; no two with those of the same one.
void StepSolver::match_last_contacts(std::size_t known) {
  matched_.assign(last_contacts_.size(), 0);
  continues_.assign(model_.constraints.size(), 0);
  auto& constraints = model_.constraints;
  for (std::size_t first = 0, end = 0; first < constraints.size(); first = end) {
    const Touching pair = bodies_of(constraints[first]);
    for (end = first + 1; end < constraints.size() && bodies_of(constraints[end]) == pair;) ++end;
    if (!is_stale(island_of_[first])) continue;
    const auto [begin, last] =
        std::ranges::equal_range(last_contacts_, pair, {}, &LastContact::bodies);
    const auto number = [this](auto at) { return static_cast<int>(at - last_contacts_.begin()); };
    matches_.clear();
    for (std::size_t i = first; i < end; ++i) {
      note_near(constraints[i], static_cast<int>(i), number(begin), number(last));
    }
    std::sort(matches_.begin(), matches_.end(), [](const Match& a, const Match& b) {
      return std::tuple(a.distance2, a.now, a.last) < std::tuple(b.distance2, b.now, b.last);
    });
    for (const Match& match : matches_) {
      const auto now = static_cast<std::size_t>(match.now),
                 last_one = static_cast<std::size_t>(match.last);
      if (continues_[now] != 0 || matched_[last_one] != 0) continue;
      continues_[now] = matched_[last_one] = 1;
      if (now >= known) continue_from(last_contacts_[last_one], constraints[now]);
    }
  }
}

/// Contacts of the same two bodies in the last step, from one to before another, that were near
/// this one.
void StepSolver::note_near(ContactConstraint& constraint, int number, int first, int end) {
  double nearest2 = kSameContact * kSameContact;
  for (int i = first; i < end; ++i) {
    const LastContact& last = last_contacts_[static_cast<std::size_t>(i)];
    const double distance2 = (last.p_W - constraint.contact.p_W).squaredNorm();
    if (distance2 >= kSameContact * kSameContact) continue;
    matches_.push_back({distance2, number, i});
    // What is left of an impact is for all that have come of it.
    if (distance2 >= nearest2) continue;
    nearest2 = distance2;
    constraint.impact_m2_s2 = last.impact_m2_s2;
  }
}

/// Those that bear a force, ordered by their bodies, then by place.
void StepSolver::keep_contacts() {
  kept_.clear();
  for (std::size_t i = 0; i < model_.constraints.size(); ++i) {
    const ContactConstraint& constraint = model_.constraints[i];
    if (constraint.normal_n > 0) kept_.emplace_back(bodies_of(constraint), static_cast<int>(i));
  }
  const auto at = [this](int i) -> const ContactConstraint& {
    return model_.constraints[static_cast<std::size_t>(i)];
  };
  std::sort(kept_.begin(), kept_.end(), [&at](const auto& a, const auto& b) {
    if (a.first != b.first) return a.first < b.first;
    const auto &p = at(a.second).contact.p_W, &q = at(b.second).contact.p_W;
    return std::tuple(p.x(), p.y(), p.z(), a.second) < std::tuple(q.x(), q.y(), q.z(), b.second);
  });
  for (const auto& [bodies, i] : kept_) {
    const ContactConstraint& constraint = at(i);
    memory_.contacts.push_back({bodies, constraint.contact.p_W, constraint.contact.n_W,
                                constraint.f_guess_W, constraint.torque_guess_W,
                                constraint.impact_m2_s2});
  }
}

// ---- the same step anew

void StepSolver::begin() {
  begun_.assign(awake_roots().begin(), awake_roots().end());
  for (const int root : begun_) {
    ode::save(model_.body(root).body.get(), before_[static_cast<std::size_t>(root)]);
  }
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    model_.grippers[r].save(grippers_before_[r]);
  }
  memory_before_.failures = memory_.failures;
  memory_before_.latest = memory_.latest;
  begins_at_last_ = false;
}

/// The state at hand and the other one.
void StepSolver::exchange() {
  for (const int root : begun_) {
    dBodyID body = model_.body(root).body.get();
    ode::SavedState other = before_[static_cast<std::size_t>(root)];
    ode::save(body, before_[static_cast<std::size_t>(root)]);
    ode::restore(body, other);
  }
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    const GripperMechanism::Solved other = grippers_before_[r];
    model_.grippers[r].save(grippers_before_[r]);
    model_.grippers[r].restore(other);
  }
  if (begins_at_last_) std::swap(memory_before_.contacts, last_contacts_);
  begins_at_last_ = false;
  std::swap(memory_, memory_before_);
}

}  // namespace aprsim::physics
