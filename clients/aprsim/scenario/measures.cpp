#include "clients/aprsim/scenario/measures.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

namespace aprsim::client {
namespace {

using Kind = BodyShape::Kind;

constexpr double kInSlot_m = 0.01;      // a gear's origin from its slot's centre, at most
constexpr double kUpright = 0.9;        // cosine of a gear's tilt, at least
constexpr double kSamePlace_m = 0.015;  // of two grasps
constexpr double kSubmittedPlace_m = 0.15;
constexpr double kSettling_s = 3;  // from release to rest, at most
constexpr double kOldRate =
    1.25;  // times the previous period per part still counts as the previous rate

double yaw_of(const Eigen::Isometry3d& pose) {
  return std::atan2(pose.linear()(1, 0), pose.linear()(0, 0));
}

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * std::numbers::pi); }

double number(std::integral auto count) { return static_cast<double>(count); }

/// Figures of the kits; the job begins at `first_s`.
void add_kits(Measured& out, double first_s) {
  auto& values = out.values;
  for (const char* name : {"kits_right", "kits_late", "parts_right"}) values[name] = 0;
  std::size_t submitted = 0;
  double last_s = 0, waited_s = 0;
  for (const KitResult& kit : out.kits) {
    values["kits_right"] += kit.is_right() ? 1 : 0;
    values["kits_late"] += kit.late ? 1 : 0;
    values["parts_right"] += kit.right;
    if (!kit.submitted_s) continue;
    ++submitted;
    last_s = std::max(last_s, *kit.submitted_s);
    waited_s += *kit.submitted_s - kit.announced_s;
  }
  values["kits_ordered"] = number(out.kits.size());
  values["kits_submitted"] = number(submitted);
  const bool all = submitted == out.kits.size() && !out.kits.empty();
  const double job_s = (all ? last_s : out.end_s) - first_s;
  values["job_s"] = job_s;
  if (submitted > 0) values["kit_mean_s"] = waited_s / number(submitted);
  if (job_s > 0) values["throughput_per_h"] = 3600 * values["kits_right"] / job_s;
}

void add_robots(Measured& out) {
  auto& values = out.values;
  for (const char* name :
       {"grasps", "grasps_failed", "grasps_repeated", "drops", "path_m", "energy_j"}) {
    values[name] = 0;
  }
  double idle = 0;
  for (const RobotResult& robot : out.robots) {
    values["grasps"] += robot.grasps;
    values["grasps_failed"] += robot.grasps_failed;
    values["grasps_repeated"] += robot.grasps_repeated;
    values["drops"] += robot.drops;
    values["path_m"] += robot.path_m;
    values["energy_j"] += robot.energy_j;
    if (robot.total_s > 0) idle += 1 - robot.moving_s / robot.total_s;
  }
  if (!out.robots.empty()) values["idle_share"] = idle / number(out.robots.size());
}

void add_placements(Measured& out) {
  auto& values = out.values;
  values["placed"] = number(out.placements.size());
  std::vector<double> errors_mm, turns_deg;
  for (const Placement& placement : out.placements) {
    errors_mm.push_back(1e3 * placement.error_m);
    turns_deg.push_back(placement.turned_rad * 180 / std::numbers::pi);
  }
  if (errors_mm.empty()) return;
  values["placement_p50_mm"] = quantile(errors_mm, 0.5);
  values["placement_p95_mm"] = quantile(errors_mm, 0.95);
  values["placement_max_mm"] = quantile(errors_mm, 1);
  values["placement_yaw_p95_deg"] = quantile(turns_deg, 0.95);
}

void add_collisions(Measured& out) {
  double max_n = 0;
  for (const Collision& collision : out.collisions) max_n = std::max(max_n, collision.max_n);
  out.values["collisions"] = number(out.collisions.size());
  out.values["collision_max_n"] = max_n;
}

/// Figures that only the controller knows.
void add_words(Measured& out, const ControllerWords& words) {
  auto& values = out.values;
  if (words.replans) values["replans"] = *words.replans;
  if (words.crcl_requests) values["crcl_requests"] = *words.crcl_requests;
  if (words.modbus_requests) values["modbus_requests"] = *words.modbus_requests;
  if (words.vision_frames) values["vision_frames"] = *words.vision_frames;
}

}  // namespace

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

struct Measures::State {
  /// State of a robot's gripper.
  struct Hand {
    bool closed = false;
    bool held_since_closing = false;
    Eigen::Vector3d closed_at = Eigen::Vector3d::Zero();
    std::optional<Eigen::Vector3d> failed_at;  ///< the last grasp, when it failed
    std::optional<std::size_t> held;
    double grasp_yaw = 0, yaw = 0;  ///< of the body in the tool
  };

  /// A released gear that is not at rest yet.
  struct Falling {
    std::size_t body = 0, robot = 0;
    double released_s = 0, turned_rad = 0;
  };

  struct Announced {
    double time_s = 0;
    unsigned open = 0;
  };

  struct Contents {
    unsigned right = 0, surplus = 0;
  };

  CellShape shape;
  std::vector<scenario::Order> orders;
  Sample last;
  bool has_sample = false;
  double moved_s = 0;
  double moved_in_curtain_s = 0;
  std::vector<Hand> hands;
  std::vector<RobotResult> robots;
  std::vector<Falling> falling;
  std::set<std::size_t> taken;  ///< bodies that were ever held
  std::vector<Placement> placements;
  std::vector<Collision> collisions;
  std::map<std::uint64_t, FaultSample> faults;
  std::map<std::string, Announced> announced;
  std::set<std::size_t> submitted_trays;
  std::vector<KitResult> kits;

  [[nodiscard]] const scenario::Order& order(const std::string& name) const {
    const auto found = std::ranges::find(orders, name, &scenario::Order::name);
    if (found == orders.end()) throw std::invalid_argument("no order " + name);
    return *found;
  }

  [[nodiscard]] const Eigen::Isometry3d& pose(std::size_t body) const {
    return last.bodies[body].pose;
  }

  [[nodiscard]] Eigen::Vector3d slot_at(std::size_t tray, const SlotShape& slot) const {
    return pose(tray) * slot.at_tray;
  }

  /// The gear in a slot, and its distance from the centre.
  [[nodiscard]] std::optional<std::pair<std::size_t, double>> gear_in(std::size_t tray,
                                                                      const SlotShape& slot) const {
    const Eigen::Vector3d centre = slot_at(tray, slot);
    std::optional<std::pair<std::size_t, double>> best;
    for (std::size_t i = 0; i < shape.bodies.size(); ++i) {
      if (shape.bodies[i].kind != Kind::kGear || last.bodies[i].lost || is_held(i)) continue;
      const double off = (pose(i).translation() - centre).norm();
      if (off <= kInSlot_m && (!best || off < best->second)) best = {i, off};
    }
    return best;
  }

  [[nodiscard]] bool is_held(std::size_t body) const {
    return std::ranges::any_of(last.robots,
                               [&](const RobotSample& robot) { return robot.held == body; });
  }

  [[nodiscard]] bool is_faulty(const std::string& gear) const {
    return std::ranges::any_of(faults, [&](const auto& entry) {
      const FaultSample& fault = entry.second;
      return fault.kind == "part-faulty" && fault.target == gear && fault.begin_s && !fault.end_s;
    });
  }

  [[nodiscard]] Contents contents(std::size_t tray, const scenario::Order& wanted) const {
    Contents out;
    for (const SlotShape& slot : shape.bodies[tray].slots) {
      const auto gear = gear_in(tray, slot);
      if (!gear) continue;
      const BodyShape& body = shape.bodies[gear->first];
      const auto part = wanted.slots.find(slot.name);
      if (part == wanted.slots.end()) {
        ++out.surplus;
      } else if (part->second == body.type && pose(gear->first).linear()(2, 2) > kUpright &&
                 !is_faulty(body.name)) {
        ++out.right;
      }
    }
    return out;
  }

  void watch_hand(const RobotSample& robot, std::size_t index) {
    Hand& hand = hands[index];
    RobotResult& sum = robots[index];
    if (robot.told_to_close && !hand.closed) {
      ++sum.grasps;
      hand.closed_at = robot.tool.translation();
      hand.held_since_closing = false;
      if (hand.failed_at && (*hand.failed_at - hand.closed_at).head<2>().norm() < kSamePlace_m) {
        ++sum.grasps_repeated;
      }
    }
    if (robot.held && hand.held != robot.held) {
      hand.held_since_closing = true;
      taken.insert(*robot.held);
      hand.grasp_yaw = wrapped(yaw_of(pose(*robot.held)) - yaw_of(robot.tool));
    }
    if (robot.held) {
      hand.yaw = wrapped(yaw_of(pose(*robot.held)) - yaw_of(robot.tool));
    } else if (hand.held) {
      if (robot.told_to_close) {
        ++sum.drops;
      } else if (shape.bodies[*hand.held].kind == Kind::kGear) {
        falling.push_back(
            {*hand.held, index, last.time_s, std::abs(wrapped(hand.yaw - hand.grasp_yaw))});
      }
    }
    if (!robot.told_to_close && hand.closed) {
      hand.failed_at.reset();
      if (!hand.held_since_closing) {
        ++sum.grasps_failed;
        hand.failed_at = hand.closed_at;
      }
    }
    hand.closed = robot.told_to_close;
    hand.held = robot.held;
  }

  /// A part that has come to rest in a slot of a kit is placed.
  void watch_falling() {
    std::erase_if(falling, [&](const Falling& part) {
      const BodySample& body = last.bodies[part.body];
      if (body.lost || is_held(part.body)) return true;
      if (!body.resting) return last.time_s > part.released_s + kSettling_s;
      for (std::size_t tray = 0; tray < shape.bodies.size(); ++tray) {
        if (shape.bodies[tray].kind != Kind::kKitTray) continue;
        for (const SlotShape& slot : shape.bodies[tray].slots) {
          const double off = (body.pose.translation() - slot_at(tray, slot)).norm();
          if (off > kInSlot_m) continue;
          placements.push_back({.time_s = part.released_s,
                                .robot = shape.robots[part.robot],
                                .gear = shape.bodies[part.body].name,
                                .slot = shape.bodies[tray].name + '/' + slot.name,
                                .error_m = off,
                                .turned_rad = part.turned_rad,
                                .right_type = slot.gear_type == shape.bodies[part.body].type});
        }
      }
      return true;
    });
  }

  void watch_touches() {
    for (const Touch& touch : last.touches) {
      const auto known =
          std::find_if(collisions.rbegin(), collisions.rend(), [&](const Collision& collision) {
            return collision.pair == touch.pair && collision.begin_s == touch.begin_s;
          });
      const Collision seen{touch.pair, touch.two_robots, touch.begin_s, touch.end_s, touch.max_n};
      if (known == collisions.rend()) {
        collisions.push_back(seen);
      } else {
        *known = seen;
      }
    }
  }

  void watch_motion(const Sample& before) {
    const double span_s = last.time_s - before.time_s;
    bool moved = std::abs(last.belt_speed_m_s) > 1e-4;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      RobotResult& sum = robots[i];
      const RobotSample &now = last.robots[i], &was = before.robots[i];
      sum.path_m += (now.tool.translation() - was.tool.translation()).norm();
      sum.energy_j += span_s * (now.power_w + was.power_w) / 2;
      moved |= now.moving;
      if (!announced.empty()) {
        sum.total_s += span_s;
        if (now.moving) sum.moving_s += span_s;
      }
      if (!now.moving) continue;
      if (!sum.moving.empty() && sum.moving.back()[1] >= before.time_s) {
        sum.moving.back()[1] = last.time_s;
      } else {
        sum.moving.push_back({before.time_s, last.time_s});
      }
    }
    if (moved) moved_s = last.time_s;
    const bool any_moves = std::ranges::any_of(last.robots, &RobotSample::moving);
    if (any_moves && last.curtain_broken && before.curtain_broken) moved_in_curtain_s += span_s;
  }

  /// Index of the kit tray of a submission.
  [[nodiscard]] std::optional<std::size_t> tray_of(
      const scenario::Order& wanted, const std::optional<Eigen::Vector2d>& place) const {
    std::optional<std::size_t> best;
    double best_cost = place ? kSubmittedPlace_m : std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < shape.bodies.size(); ++i) {
      if (shape.bodies[i].kind != Kind::kKitTray) continue;
      const bool again = submitted_trays.contains(i);
      double cost = 0;
      if (place) {
        cost = (pose(i).translation().head<2>() - *place).norm();
      } else if (shape.bodies[i].type == wanted.tray && !again) {
        const Contents in = contents(i, wanted);
        cost = static_cast<double>(in.surplus) - static_cast<double>(in.right);
      } else {
        continue;
      }
      if (cost >= best_cost) continue;
      best = i;
      best_cost = cost;
    }
    // A submission with a tray's place selects that tray.
    return best && submitted_trays.contains(*best) ? std::nullopt : best;
  }

  void add_faults(Measured& out) const {
    const bool all_right = !kits.empty() && std::ranges::all_of(out.kits, &KitResult::is_right);
    for (const auto& [id, fault] : faults) {
      if (!fault.begin_s) continue;
      FaultResult result{fault.kind, fault.target, *fault.begin_s, fault.end_s, {}, all_right};
      for (const Placement& placement : placements) {
        if (placement.time_s <= result.begin_s) continue;
        result.recovery_s = placement.time_s - result.begin_s;
        result.recovered = true;
        break;
      }
      out.faults.push_back(std::move(result));
    }
  }
};

Measures::Measures(CellShape shape, std::vector<scenario::Order> orders)
    : state_(std::make_unique<State>()) {
  state_->shape = std::move(shape);
  state_->orders = std::move(orders);
  state_->hands.resize(state_->shape.robots.size());
  for (const auto& name : state_->shape.robots) state_->robots.push_back({.name = name});
}
Measures::~Measures() = default;

void Measures::add(const Sample& sample) {
  State& s = *state_;
  if (sample.robots.size() != s.robots.size() || sample.bodies.size() != s.shape.bodies.size()) {
    throw std::invalid_argument("a sample of another cell");
  }
  if (s.has_sample && sample.time_s <= s.last.time_s) return;
  const Sample before = std::exchange(s.last, sample);
  for (const FaultSample& fault : sample.faults) s.faults[fault.id] = fault;
  for (std::size_t i = 0; i < s.robots.size(); ++i) {
    if (!s.has_sample) s.hands[i].closed = sample.robots[i].told_to_close;
    s.watch_hand(sample.robots[i], i);
  }
  s.watch_falling();
  s.watch_touches();
  if (s.has_sample) s.watch_motion(before);
  if (!s.has_sample) s.moved_s = sample.time_s;
  s.has_sample = true;
}

void Measures::announced(const std::string& order) {
  state_->announced[order] = {state_->last.time_s, state_->order(order).count};
}

void Measures::cancelled(const std::string& order) {
  static_cast<void>(state_->order(order));
  const auto found = state_->announced.find(order);
  if (found != state_->announced.end()) found->second.open = 0;
}

bool Measures::submitted(const std::string& name, const std::optional<Eigen::Vector2d>& place) {
  State& s = *state_;
  const scenario::Order& wanted = s.order(name);
  const auto announced = s.announced.find(name);
  if (announced == s.announced.end() || announced->second.open == 0) return false;
  const auto tray = s.tray_of(wanted, place);
  if (!tray) return false;
  --announced->second.open;
  s.submitted_trays.insert(*tray);
  const State::Contents in = s.contents(*tray, wanted);
  KitResult kit{.order = name,
                .tray = s.shape.bodies[*tray].name,
                .priority = wanted.priority,
                .announced_s = announced->second.time_s,
                .submitted_s = s.last.time_s,
                .tray_right = s.shape.bodies[*tray].type == wanted.tray,
                .ordered = static_cast<unsigned>(wanted.slots.size()),
                .right = in.right,
                .surplus = in.surplus};
  kit.late = wanted.deadline_s && s.last.time_s > kit.announced_s + *wanted.deadline_s;
  if (wanted.destination) {
    const Eigen::Vector3d at = s.pose(*tray).translation();
    kit.at_destination =
        at.x() >= wanted.destination->min_m[0] && at.x() <= wanted.destination->max_m[0] &&
        at.y() >= wanted.destination->min_m[1] && at.y() <= wanted.destination->max_m[1];
  }
  s.kits.push_back(std::move(kit));
  return true;
}

unsigned Measures::open(const std::string& order) const {
  const auto found = state_->announced.find(order);
  return found == state_->announced.end() ? 0 : found->second.open;
}

unsigned Measures::fulfilled(const std::string& order) const {
  const State& s = *state_;
  const scenario::Order& wanted = s.order(order);
  unsigned count = 0;
  for (std::size_t i = 0; i < s.shape.bodies.size(); ++i) {
    if (s.shape.bodies[i].type != wanted.tray || s.submitted_trays.contains(i)) continue;
    const State::Contents in = s.contents(i, wanted);
    if (in.right == wanted.slots.size() && in.surplus == 0) ++count;
  }
  return count;
}

unsigned Measures::submitted_kits(const std::string& order) const {
  return static_cast<unsigned>(std::ranges::count(state_->kits, order, &KitResult::order));
}

std::size_t Measures::filled(const std::string& order) const {
  const State& s = *state_;
  const scenario::Order& wanted = s.order(order);
  std::size_t parts = 0;
  for (const KitResult& kit : s.kits) {
    if (kit.order == order) parts += kit.right;
  }
  std::vector<unsigned> begun;
  for (std::size_t i = 0; i < s.shape.bodies.size(); ++i) {
    if (s.shape.bodies[i].type != wanted.tray || s.submitted_trays.contains(i)) continue;
    begun.push_back(s.contents(i, wanted).right);
  }
  std::ranges::sort(begun, std::greater<>());
  if (begun.size() > open(order)) begun.resize(open(order));
  for (const unsigned right : begun) parts += right;
  return parts;
}

std::size_t Measures::placed() const { return state_->placements.size(); }

double Measures::quiet_s() const { return state_->last.time_s - state_->moved_s; }

Measured Measures::result(const ControllerWords& words) const {
  const State& s = *state_;
  Measured out{.placements = s.placements, .collisions = s.collisions, .robots = s.robots};
  out.end_s = s.last.time_s;
  out.kits = s.kits;
  double first_s = s.last.time_s;  // the first order's announcement
  for (const auto& [name, announced] : s.announced) first_s = std::min(first_s, announced.time_s);
  for (const auto& order : s.orders) {
    const auto announced = s.announced.find(order.name);
    if (announced == s.announced.end()) continue;
    for (unsigned i = 0; i < announced->second.open; ++i) {
      out.kits.push_back({.order = order.name,
                          .priority = order.priority,
                          .announced_s = announced->second.time_s,
                          .late = order.deadline_s.has_value(),
                          .ordered = static_cast<unsigned>(order.slots.size())});
    }
  }
  s.add_faults(out);
  add_kits(out, first_s);
  add_robots(out);
  add_placements(out);
  add_collisions(out);
  auto& values = out.values;
  values["parts_lost"] =
      number(std::ranges::count_if(s.taken, [&](std::size_t body) { return !is_somewhere(body); }));
  values["held_end"] = number(std::ranges::count_if(
      s.last.robots, [](const RobotSample& robot) { return robot.held.has_value(); }));
  values["run_s"] = s.last.time_s;
  values["moved_in_curtain_s"] = s.moved_in_curtain_s;
  add_recovery(out, first_s);
  add_words(out, words);
  return out;
}

bool Measures::is_somewhere(std::size_t body) const {
  const State& s = *state_;
  if (s.is_held(body)) return true;
  if (s.last.bodies[body].lost) return false;
  for (std::size_t tray = 0; tray < s.shape.bodies.size(); ++tray) {
    for (const SlotShape& slot : s.shape.bodies[tray].slots) {
      const auto gear = s.gear_in(tray, slot);
      if (gear && gear->first == body) return true;
    }
  }
  return false;
}

void Measures::add_recovery(Measured& out, double first_s) const {
  auto& values = out.values;
  values["faults"] = static_cast<double>(out.faults.size());
  values["faults_recovered"] =
      static_cast<double>(std::ranges::count_if(out.faults, &FaultResult::recovered));
  std::vector<double> recoveries;
  double fault_s = -1;
  for (const FaultResult& fault : out.faults) {
    if (fault.recovery_s) recoveries.push_back(*fault.recovery_s);
    fault_s = std::max(fault_s, fault.begin_s);
  }
  if (!recoveries.empty()) {
    values["recovery_mean_s"] = std::accumulate(recoveries.begin(), recoveries.end(), 0.0) /
                                static_cast<double>(recoveries.size());
    values["recovery_max_s"] = std::ranges::max(recoveries);
  }
  std::vector<double> times;
  for (const Placement& placement : out.placements) times.push_back(placement.time_s);
  std::ranges::sort(times);
  const auto after = std::ranges::upper_bound(times, fault_s);
  const auto before = after - times.begin();
  if (fault_s < 0 || before < 2) return;
  const double usual_s = (fault_s - first_s) / static_cast<double>(before);
  for (auto next = after; next != times.end() && next + 1 != times.end(); ++next) {
    if (*(next + 1) - *next > kOldRate * usual_s) continue;
    values["rate_back_s"] = *next - fault_s;
    return;
  }
}

}  // namespace aprsim::client
