#include "world/physics/step/step_solver.hpp"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>

#include <Eigen/LU>

#include "world/base/simd/vector_clones.hpp"
#include "world/physics/constraint/contact_solver_parameters.hpp"
#include "world/physics/step/make_engine.hpp"

namespace aprsim::physics {
namespace {

constexpr double kSameContact = 3e-3;  // [m] from where it was in the last step, at most
constexpr double kSameFace = 0.9;      // cosine between its normals then and now
constexpr double kSamePlane = 0.98;    // the same, of contacts that take over each other's force
constexpr double kFalling = 0.03;      // [m/s], slower bodies lie on something

/// The smallest rotation from one normal to another; none if they differ too much.
class NormalRotation {
 public:
  NormalRotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const double cosine = from.dot(to);
    if (cosine < kSameFace) return;
    axis_ = from.cross(to);
    scale_ = 1 / (1 + cosine);
  }
  // Rodrigues' formula without trigonometry: R = 1 + [a] + [a]^2 / (1 + c), with a = from x to, c =
  // from . to.
  Eigen::Vector3d operator()(const Eigen::Vector3d& v) const {
    const Eigen::Vector3d across = axis_.cross(v);
    return v + across + scale_ * axis_.cross(across);
  }

 private:
  Eigen::Vector3d axis_ = Eigen::Vector3d::Zero();  // times the angle's sine
  double scale_ = 0;
};

void warm_start_from(const StepSolver::LastContact& last, ContactConstraint& constraint) {
  const bool has_torsion = constraint.has_torsion();
  constraint.f_guess_W = last.f_guess_W;
  constraint.creep_W = last.creep_W;
  if (has_torsion) constraint.torque_guess_W = last.torque_guess_W;
  if (last.n_W == constraint.contact.n_W) return;
  // The last force is in world axes. It is rotated with the normal: otherwise a rolling or turning
  // part would start with a wrong direction of friction.
  const NormalRotation rotated(last.n_W, constraint.contact.n_W);
  const auto rotate = [&rotated](auto& guess) {
    guess.last = rotated(guess.last);
    guess.change = rotated(guess.change);
  };
  rotate(constraint.f_guess_W);
  constraint.creep_W = rotated(last.creep_W);
  if (has_torsion) rotate(constraint.torque_guess_W);
}

StepSolver::ContactingBodies bodies_of(const ContactConstraint& constraint) {
  return {constraint.contact.a, constraint.contact.b, constraint.fixed};
}

/// Zero without a body: the ground.
Eigen::Vector3d velocity_at(const RigidBody* body, const Eigen::Vector3d& p_W) {
  return body == nullptr ? Eigen::Vector3d::Zero() : body->velocity_at(p_W);
}

/// Exchanges the motion of `body` with `other`.
void exchange_motion(RigidBody& body, BodyMotion& other) {
  const BodyMotion own = body.motion();
  body.restore(other);
  other = own;
}

}  // namespace

StepSolver::StepSolver(PhysicsModel& model)
    : model_(model),
      islands_(model),
      engine_(make_engine(model.scene.physics)),
      before_(model.bodies.size()),
      grippers_before_(model.grippers.size()) {
  roots_before_.reserve(model.bodies.size());
  const std::size_t islands = model.bodies.size() + model.grippers.size();
  stale_.resize(islands, 1);
  first_root_.resize(islands);
  first_run_.resize(islands);
  root_count_.resize(islands);
  next_root_.resize(model.bodies.size());
  // Bodies that may be the first of a contact.
  const int firsts = model.ids.palm(static_cast<int>(model.grippers.size()));
  // All lists get their capacity here, because a step must not allocate.
  for (auto* by_body : {&first_of_body_, &first_last_run_}) by_body->resize(index(firsts));
  for (auto* runs : {&runs_, &last_runs_}) runs->reserve(kConstraintCapacity);
  for (auto* contacts : {&bearing_, &bearers_}) contacts->reserve(kConstraintCapacity);
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

void StepSolver::solve_again(std::size_t known) {
  // A search that has woken bodies changes islands and unknowns: nothing of the former solution can
  // be kept.
  if (awake_set_changed()) {
    begin();
    return step();
  }
  islands_.find(model_, model_.constraints);
  std::fill(stale_.begin(), stale_.end(), 0);
  const auto mark_stale = [this](int island) { stale_[static_cast<std::size_t>(island)] = 1; };
  for (std::size_t i = known; i < model_.constraints.size(); ++i) {
    mark_stale(islands_.number_of(model_, model_.constraints[i]));
  }
  // External loads were added to the bodies once more, so that their islands count as changed.
  // The suction has been applied again.
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    if (model_.grippers[r].suction().force_n > 0) {
      mark_stale(islands_.number_of_gripper(static_cast<int>(r)));
    }
  }
  restart_stale();
  solve_stale(known);
}

bool StepSolver::awake_set_changed() const {
  return !std::ranges::equal(roots_before_, awake_roots());
}

/// Stale islands restart from the state before the step; the others keep their solution.
void StepSolver::restart_stale() {
  for (const int root : roots_before_) {
    // `before_` has the state before the step. It is exchanged with the solved one, which clean
    // islands get back.
    RigidBody& body = model_.body(root).body;
    BodyMotion& kept = before_[index(root)];
    const BodyMotion solved = std::exchange(kept, body.motion());
    if (!is_stale(islands_.number_of_root(root))) body.restore(solved);
  }
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    const GripperBodies::Solved solved = grippers_before_[r];
    model_.grippers[r].save(grippers_before_[r]);
    const int island = islands_.number_of_gripper(static_cast<int>(r));
    if (!is_stale(island)) model_.grippers[r].restore(solved);
  }
  // Failures of the undone solve stay counted.
  std::swap(memory_.failures, memory_before_.failures);
  std::swap(memory_.latest, memory_before_.latest);
}

/// The first `known` contacts have been solved once in this step.
void StepSolver::solve_stale(std::size_t known) {
  // Islands are solved in ascending order of their lowest body. The order fixes the bits; the
  // islands themselves are independent.
  list_members();
  list_runs();
  index_last_contacts();
  match_last_contacts(known);
  // An island has the number of its lowest root.
  for (const int root : awake_roots()) {
    if (islands_.number_of_root(root) == root && is_stale(root)) solve_island(root);
  }
  // Grippers on their own.
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    const int own = model_.ids.free_count() + static_cast<int>(r);
    const int island = islands_.number_of_gripper(static_cast<int>(r));
    if (island == own && !model_.grippers[r].idle() && is_stale(island)) solve_island(island);
  }
  save_contacts();
}

/// Each island's roots, ascending.
void StepSolver::list_members() {
  std::fill(first_root_.begin(), first_root_.end(), -1);
  std::fill(root_count_.begin(), root_count_.end(), 0);
  const auto roots = awake_roots();
  for (const int root : roots) ++root_count_[index(islands_.number_of_root(root))];
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) {
    next_root_[index(*root)] =
        std::exchange(first_root_[index(islands_.number_of_root(*root))], *root);
  }
}

void StepSolver::append(int contact, const ContactingBodies& bodies, std::vector<Run>& runs) {
  if (runs.empty() || runs.back().bodies != bodies) runs.push_back({bodies, contact});
  runs.back().end = contact + 1;
}

/// The contacts in runs, and each island's runs in a list.
void StepSolver::list_runs() {
  const auto& constraints = model_.constraints;
  runs_.clear();
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    append(static_cast<int>(i), bodies_of(constraints[i]), runs_);
  }
  std::fill(first_run_.begin(), first_run_.end(), -1);
  for (std::size_t r = runs_.size(); r > 0; --r) {
    Run& run = runs_[r - 1];
    run.island = islands_.number_of(model_, constraints[index(run.first)]);
    run.next = std::exchange(first_run_[index(run.island)], static_cast<int>(r) - 1);
  }
}

void StepSolver::solve_island(int island) {
  engine_->begin({.step_s = model_.step_s,
                  .gravity_W = model_.gravity_W(),
                  .residual_m_s = model_.scene.physics.residual_m_s,
                  .number = step_number_});
  for (int root = first_root_[index(island)]; root >= 0; root = next_root_[index(root)]) {
    engine_->add_body(model_.body(root).body);
  }
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    if (islands_.number_of_gripper(static_cast<int>(r)) != island) continue;
    if (!model_.grippers[r].idle()) model_.grippers[r].add_to(*engine_);
  }
  // Rows are added in a fixed order: gripper, virtual joints, contacts. The solver's sums depend on
  // it.
  if (auto* joints = model_.simplification.virtual_joints()) {
    const auto pairs = joints->pairs();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (islands_.number_of_root(pairs[i].a) == island) joints->add_to(*engine_, i);
    }
  }
  for (int r = first_run_[index(island)]; r >= 0; r = runs_[index(r)].next) {
    add_contacts(runs_[index(r)]);
  }
  record(engine_->advance());
  const ContactSolverStatistics* statistics = engine_->statistics();
  if (observer_ && statistics != nullptr) observer_(*statistics);
}

/// Places a touched arm's link at its pose in this step.
void StepSolver::add_contacts(const Run& run) {
  const auto [a, b, fixed] = run.bodies;
  ContactSetting setting{.arm_link = model_.ids.is_link(b),
                         .belt_axis_W = model_.fixed.belt_axis_W,
                         .belt_speed_m_s = model_.belt_speed_m_s,
                         .step_s = model_.step_s,
                         .flight_step_s = model_.scene.physics.step_s};
  if (setting.arm_link) {
    const auto robot = index(model_.ids.robot_of(b));
    model_.arms[robot].place_link(model_.ids.link_of(b), model_.step_s);
  }
  RigidBody *body_a = model_.rigid_body(a), *body_b = model_.rigid_body(b);
  const bool free_a = model_.ids.is_free(a), free_b = model_.ids.is_free(b);
  for (int i = run.first; i < run.end; ++i) {
    ContactConstraint& constraint = model_.constraints[index(i)];
    if (constraint.restitution > 0) {
      const Contact& contact = constraint.contact;
      const Eigen::Vector3d v_a = velocity_at(body_a, contact.p_W);
      const Eigen::Vector3d v_b = velocity_at(body_b, contact.p_W);
      // Newton's law of impact needs the approach velocity before the step, at the contact point.
      setting.normal_speed_m_s = (v_a - v_b).dot(contact.n_W);
      // A body that hardly moves is supported, and so does not accelerate freely.
      const double fall = -model_.scene.physics.gravity_m_s2 * contact.n_W.z();
      setting.normal_accel_m_s2 = (free_a && v_a.norm() > kFalling ? fall : 0) -
                                  (free_b && v_b.norm() > kFalling ? fall : 0);
    } else {
      setting.normal_speed_m_s = setting.normal_accel_m_s2 = 0;
    }
    engine_->add_contact(body_a, body_b, constraint, setting);
  }
}

void StepSolver::record(const EngineOutcome& outcome) {
  const auto iterations = static_cast<std::uint32_t>(outcome.iterations);
  ++work_.solved;
  work_.iterations += iterations;
  memory_.latest.iterations = std::max(memory_.latest.iterations, iterations);
  memory_.latest.residual_m_s = std::max(memory_.latest.residual_m_s, outcome.residual_m_s);
  if (outcome.converged) return;
  ++memory_.failures.not_converged;
  memory_.failures.max_residual_m_s =
      std::max(memory_.failures.max_residual_m_s, outcome.residual_m_s);
}

// ---- warm start

void StepSolver::index_last_contacts() {
  // Last contacts are sorted by pair, so that each run of a pair is found by its first body.
  std::swap(last_contacts_, memory_.contacts);
  memory_.contacts.clear();
  holds_last_contacts_ = true;
  last_runs_.clear();
  for (std::size_t i = 0; i < last_contacts_.size(); ++i) {
    append(static_cast<int>(i), last_contacts_[i].bodies, last_runs_);
  }
  std::fill(first_last_run_.begin(), first_last_run_.end(), -1);
  for (std::size_t r = last_runs_.size(); r > 0; --r) {
    const BodyIndex a = last_runs_[r - 1].bodies.a;
    if (a >= 0 && index(a) < first_last_run_.size()) {
      first_last_run_[index(a)] = static_cast<int>(r) - 1;
    }
  }
}

/// Contacts of the same two bodies in the last step; null if there were none.
const StepSolver::Run* StepSolver::last_run(const ContactingBodies& bodies) const {
  const int first = first_last_run_[index(bodies.a)];
  if (first < 0) return nullptr;
  for (std::size_t r = index(first); r < last_runs_.size(); ++r) {
    if (last_runs_[r].bodies == bodies) return &last_runs_[r];
    if (last_runs_[r].bodies.a != bodies.a) break;
  }
  return nullptr;
}

/// Warm-starts each contact behind the `known` ones with the force of the nearest last contact of
/// the same two bodies, rotated with its normal. No last contact is used twice.
APRSIM_VECTOR_CLONES void StepSolver::match_last_contacts(std::size_t known) {
  matched_.assign(last_contacts_.size(), 0);
  continues_.assign(model_.constraints.size(), 0);
  for (const Run& run : runs_) {
    if (!is_stale(run.island)) continue;
    reset_guesses(run, known);
    const Run* last = last_run(run.bodies);
    if (last == nullptr) continue;
    // Greedy assignment by distance. Most contacts have one candidate, and sorting is skipped for
    // them.
    if (list_near_contacts(run, *last)) {
      std::sort(matches_.begin(), matches_.end(), [](const Match& a, const Match& b) {
        return std::tuple(a.distance2, a.now, a.last) < std::tuple(b.distance2, b.now, b.last);
      });
    }
    for (const Match& match : matches_) {
      const std::size_t now = index(match.now), last_one = index(match.last);
      if (continues_[now] != 0 || matched_[last_one] != 0) continue;
      continues_[now] = matched_[last_one] = 1;
      if (now >= known) warm_start_from(last_contacts_[last_one], model_.constraints[now]);
    }
    if (root_count_[index(run.island)] > ContactSolverParameters{}.max_small_island_bodies) {
      spread_lost_forces(run, *last, known);
    }
  }
}

/// In a heap a lost force is a disturbance of all bodies above it. A disc that lies flat touches at
/// other places of its rim from step to step: the new contacts of a pair take over the forces of
/// those that are gone.
void StepSolver::spread_lost_forces(const Run& run, const Run& last, std::size_t known) {
  for (int k = last.first; k < last.end; ++k) {
    if (matched_[index(k)] != 0) continue;
    const LastContact& lost = last_contacts_[index(k)];
    bearers_.clear();
    for (int i = std::max(run.first, static_cast<int>(known)); i < run.end; ++i) {
      const Contact& contact = model_.constraints[index(i)].contact;
      if (continues_[index(i)] == 0 && contact.n_W.dot(lost.n_W) > kSamePlane) {
        bearers_.push_back(i);
      }
    }
    matched_[index(k)] = 1;
    if (!bearers_.empty()) spread_force(lost);
  }
}

/// In shares that keep the force's place as well as the bearing contacts allow: the least ones,
/// 1/n + (p_i - c)' A^-1 (p - c) with A = sum (p_i - c) (p_i - c)' about the centre c, none of them
/// negative.
void StepSolver::spread_force(const LastContact& lost) {
  constexpr double kFlat = 1e-3, kPoint_m2 = 1e-14;  // A is regular also of contacts in a line
  const double count = static_cast<double>(bearers_.size());
  const auto at = [this](int i) -> ContactConstraint& { return model_.constraints[index(i)]; };
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const int i : bearers_) centre += at(i).contact.p_W / count;
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  for (const int i : bearers_) {
    const Eigen::Vector3d arm = at(i).contact.p_W - centre;
    A += arm * arm.transpose();
  }
  A.diagonal().array() += kFlat * A.trace() + kPoint_m2;
  const Eigen::Vector3d slope = A.inverse() * (lost.p_W - centre);
  const auto share = [&](int i) {
    return std::max(0.0, 1 / count + slope.dot(at(i).contact.p_W - centre));
  };
  double sum = 0;
  for (const int i : bearers_) sum += share(i);
  for (const int i : bearers_) {
    ContactConstraint& constraint = at(i);
    constraint.f_guess_W.last += share(i) / sum * lost.f_guess_W.last;
    constraint.f_guess_W.known = true;
    if (constraint.has_torsion()) {
      constraint.torque_guess_W.last += share(i) / sum * lost.torque_guess_W.last;
      constraint.torque_guess_W.known = true;
    }
  }
}

/// Warm-starts the `known` contacts with their solution of this very step.
void StepSolver::reset_guesses(const Run& run, std::size_t known) {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  for (std::size_t i = index(run.first); i < index(run.end); ++i) {
    ContactConstraint& constraint = model_.constraints[i];
    // A step that is solved again starts from its own first solution: that is closer than the last
    // step.
    if (!constraint.f_guess_W.known) continue;  // not solved so far
    constraint.f_guess_W = ForceGuess(i < known ? constraint.f_W : zero);
    if (constraint.has_torsion()) {
      constraint.torque_guess_W = ForceGuess(i < known ? constraint.torque_W : zero);
    }
    constraint.normal_n = 0;
    constraint.impact_m2_s2 = 0;
  }
}

/// Lists the last contacts near the present ones. True if one is near two of the others, so that
/// the order of matching matters.
bool StepSolver::list_near_contacts(const Run& now, const Run& last) {
  constexpr double kNear2 = kSameContact * kSameContact;
  constexpr int kBits = 64;
  std::uint64_t taken = 0;  // by last contact; beyond 64 of them bits are shared
  bool order_matters = false;
  matches_.clear();
  for (int i = now.first; i < now.end; ++i) {
    ContactConstraint& constraint = model_.constraints[index(i)];
    double nearest2 = kNear2;
    const std::size_t before = matches_.size();
    for (int k = last.first; k < last.end; ++k) {
      const LastContact& contact = last_contacts_[index(k)];
      const double distance2 = (contact.p_W - constraint.contact.p_W).squaredNorm();
      if (distance2 >= kNear2) continue;
      const std::uint64_t bit = std::uint64_t{1} << ((k - last.first) % kBits);
      order_matters = order_matters || matches_.size() > before || (taken & bit) != 0;
      // One bit per last contact tells whether two present ones compete for it.
      taken |= bit;
      matches_.push_back({distance2, i, k});
      // The unanswered part of an impact belongs to every contact that continues it.
      if (distance2 >= nearest2) continue;
      nearest2 = distance2;
      constraint.impact_m2_s2 = contact.impact_m2_s2;
    }
  }
  return order_matters;
}

/// Saves the contacts that bear a force, ordered by their bodies, then by position.
void StepSolver::save_contacts() {
  std::fill(first_of_body_.begin(), first_of_body_.end(), -1);
  for (std::size_t r = runs_.size(); r > 0; --r) {
    // Insertion into the list of the first body, sorted by pair. Lists are short: a body has few
    // partners.
    Run& run = runs_[r - 1];
    int* before = &first_of_body_[index(run.bodies.a)];
    while (*before >= 0 && runs_[index(*before)].bodies < run.bodies) {
      before = &runs_[index(*before)].next;
    }
    run.next = std::exchange(*before, static_cast<int>(r) - 1);
  }
  for (const int first : first_of_body_) {
    for (int r = first; r >= 0;) r = save_contacts_of_pair(r);
  }
}

/// Saves those of all runs of one pair, which follow each other in a list from `first` on. Returns
/// the run behind them.
int StepSolver::save_contacts_of_pair(int first) {
  const ContactingBodies bodies = runs_[index(first)].bodies;
  const auto at = [this](int i) -> const ContactConstraint& {
    return model_.constraints[index(i)];
  };
  bearing_.clear();
  int r = first;
  for (; r >= 0 && runs_[index(r)].bodies == bodies; r = runs_[index(r)].next) {
    for (int i = runs_[index(r)].first; i < runs_[index(r)].end; ++i) {
      if (at(i).normal_n > 0) bearing_.push_back(i);
    }
  }
  // Order by position: contact order from the search may differ between runs that resume a saved
  // state.
  std::sort(bearing_.begin(), bearing_.end(), [&at](int i, int k) {
    const auto &p = at(i).contact.p_W, &q = at(k).contact.p_W;
    if (p.x() != q.x()) return p.x() < q.x();
    if (p.y() != q.y()) return p.y() < q.y();
    return p.z() != q.z() ? p.z() < q.z() : i < k;
  });
  for (const int i : bearing_) {
    const ContactConstraint& constraint = at(i);
    memory_.contacts.push_back({bodies, constraint.contact.p_W, constraint.contact.n_W,
                                constraint.f_guess_W, constraint.torque_guess_W,
                                constraint.impact_m2_s2, constraint.creep_W});
  }
  return r;
}

// ---- undo

void StepSolver::begin() {
  roots_before_.assign(awake_roots().begin(), awake_roots().end());
  for (const int root : roots_before_) before_[index(root)] = model_.body(root).body.motion();
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    model_.grippers[r].save(grippers_before_[r]);
  }
  memory_before_.failures = memory_.failures;
  memory_before_.latest = memory_.latest;
  holds_last_contacts_ = false;
}

/// Exchanges the present state with the saved one.
void StepSolver::exchange() {
  for (const int root : roots_before_)
    exchange_motion(model_.body(root).body, before_[index(root)]);
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    const GripperBodies::Solved other = grippers_before_[r];
    model_.grippers[r].save(grippers_before_[r]);
    model_.grippers[r].restore(other);
  }
  if (holds_last_contacts_) std::swap(memory_before_.contacts, last_contacts_);
  holds_last_contacts_ = false;
  std::swap(memory_, memory_before_);
}

}  // namespace aprsim::physics
