// Free moves that go round what stands in their way: both robots of the default cell move between
// random postures at once. It counts solved moves, times the search, compares the paths with the
// best of long searches, and counts contacts in the physics.

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/support/cell_script.hpp"
#include "world/cell/observation/cell_surroundings.hpp"
#include "world/robot/avoidance/path_search.hpp"

namespace aprsim::bench {
namespace {

/// Processor time of this thread [ms]: what else runs does not count.
double processor_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

constexpr std::size_t kRobots = 2;
constexpr robot::PathSearchEffort kLong{.iterations = 4000,
                                        .attempts = 20,
                                        .good_length = 0,
                                        .shortcuts = 300,
                                        .evaluations = 3'000'000};
/// Longest path beside the best of long searches.
constexpr double kGoodLength = 1.3;
constexpr int kCompared = 10;  ///< every so many blocked pairs are searched at length as well
constexpr int kLongestMove = 60'000;  // steps

/// Results of the moves of one robot.
struct Tally {
  int pairs = 0, blocked = 0;  ///< blocked: not free in a straight line of joint space
  int reached = 0, refused = 0;
  int impossible = 0;                              ///< refused, and by a long search as well
  int compared = 0, good = 0;                      ///< length beside the best of long searches
  std::vector<double> search_ms, vain_ms, ratios;  ///< vain: searches that found nothing
};

class FreeMoves {
 public:
  FreeMoves(int pairs, bool with_searches)
      : pairs_(pairs), with_searches_(with_searches), scene_(scene_of()), cell_(scene_) {
    around_ = std::make_unique<world::CellSurroundings>(*scene_, *cell_.world.models());
    for (std::size_t r = 0; r < kRobots; ++r) {
      const robot::ArmModel& model = (*cell_.world.models())[r];
      limits_.push_back(robot::derive_joint_limits(model, {}, {0, 0, -9.81}));
      act(r, api::InitRobot{});
      for (const auto limit : {api::MotionLimit::kTransSpeed, api::MotionLimit::kTransAccel,
                               api::MotionLimit::kRotSpeed, api::MotionLimit::kRotAccel}) {
        act(r, api::SetMotionLimit{limit, true, 1});
      }
    }
  }

  void run() {
    while (std::ranges::any_of(tally, [&](const Tally& each) { return each.pairs < pairs_; })) {
      for (std::size_t r = 0; r < kRobots; ++r) {
        if (!busy(r)) next(r);
      }
      cell_.world.step();
      cell_.world.write(cell_.now);
    }
    for (int i = 0; i < kLongestMove && (busy(0) || busy(1)); ++i) {
      cell_.world.step();
      cell_.world.write(cell_.now);
    }
    for (std::size_t r = 0; r < kRobots; ++r) count(r);
  }
  [[nodiscard]] std::uint64_t hash() const { return cell_.world.state_hash(); }
  [[nodiscard]] std::size_t contacts() const {
    return cell_.now.unintended_contacts ? cell_.now.unintended_contacts->size() : 0;
  }

  std::array<Tally, kRobots> tally;

 private:
  static std::shared_ptr<const scene::Scene> scene_of() {
    scene::Scene scene = *test::load_scene("aprs");
    for (scene::Robot& robot : scene.robots) robot.planning = api::PlanningMode::kAvoid;
    return std::make_shared<const scene::Scene>(std::move(scene));
  }
  void act(std::size_t r, api::RobotAction action) {
    cell_.world.apply(++ticket_, api::RobotCommand{static_cast<int>(r), std::move(action), {}});
    cell_.world.write(cell_.now);
  }
  [[nodiscard]] bool busy(std::size_t r) const {
    return cell_.now.robots[r].action.state == api::ActionState::kWorking;
  }
  [[nodiscard]] robot::JointVector posture(std::size_t r) const {
    return cell_.world.robots()[r].q();
  }

  /// Counts the move that has ended.
  void count(std::size_t r) {
    Tally& mine = tally[r];
    if (!std::exchange(moving_[r], false)) return;
    const bool done = cell_.now.robots[r].action.state == api::ActionState::kDone;
    ++(done ? mine.reached : mine.refused);
    if (!done && with_searches_ && !solvable(r)) ++mine.impossible;
  }

  /// Begins the next move.
  void next(std::size_t r) {
    Tally& mine = tally[r];
    count(r);
    if (cell_.now.robots[r].action.state == api::ActionState::kError) {
      return act(r, api::InitRobot{});
    }
    // The other robot moves on until both are done.
    const auto goal = random_goal(r);
    if (!goal) return;
    if (mine.pairs < pairs_) {
      ++mine.pairs;
      moving_[r] = true;
      if (with_searches_) measure(r, *goal);
    }
    api::MoveJoints move;
    for (int i = 0; i < goal->size(); ++i) {
      const auto slot = static_cast<std::size_t>(i);
      move.targets.push_back(
          {i, (*goal)(i), (*cell_.world.models())[r].joints[slot].max_speed_rad_s, std::nullopt});
    }
    act(r, std::move(move));
  }

  std::shared_ptr<const robot::Surroundings> gather(std::size_t r) {
    around_->set_present(cell_.world.robots(), cell_.world.physics(), {});
    return around_->gather(static_cast<int>(r), api::PlanningMode::kAvoid);
  }

  /// A posture that is free of everything at this moment.
  std::optional<robot::JointVector> random_goal(std::size_t r) {
    const robot::ArmModel& model = (*cell_.world.models())[r];
    const auto around = gather(r);
    robot::CollisionChecker checker(model, *around);
    for (int attempt = 0; attempt < 200; ++attempt) {
      robot::JointVector q(model.dof());
      for (Eigen::Index i = 0; i < q.size(); ++i) {
        const double unit = static_cast<double>(random_() >> 11) * 0x1p-53;
        q(i) = limits_[r].lower(i) + unit * (limits_[r].upper(i) - limits_[r].lower(i));
      }
      if (checker.is_free(q)) return q;
    }
    return std::nullopt;
  }

  /// The same search as the robot's, timed, and now and then a long one beside it.
  void measure(std::size_t r, const robot::JointVector& goal) {
    Tally& mine = tally[r];
    const robot::ArmModel& model = (*cell_.world.models())[r];
    last_[r] = {gather(r), posture(r), goal};
    const double begin_ms = processor_ms();
    robot::CollisionChecker checker(model, *last_[r].around);
    if (!checker.set_ends(last_[r].start, goal)) return;
    robot::PathSearch search(checker, limits_[r]);
    const auto path = search.find(last_[r].start, goal, {});
    (path.empty() ? mine.vain_ms : mine.search_ms).push_back(processor_ms() - begin_ms);
    if (path.size() <= 2) return;
    if (mine.blocked++ % kCompared != 0) return;
    const auto best = search.find(last_[r].start, goal, kLong);
    if (best.empty()) return;
    const double ratio = search.length(path) / std::min(search.length(path), search.length(best));
    ++mine.compared;
    if (ratio <= kGoodLength) ++mine.good;
    mine.ratios.push_back(ratio);
  }

  /// Whether a long search solves the robot's last move.
  bool solvable(std::size_t r) {
    const Last& last = last_[r];
    robot::CollisionChecker checker((*cell_.world.models())[r], *last.around);
    if (!checker.set_ends(last.start, last.goal)) return false;
    robot::PathSearch search(checker, limits_[r]);
    return !search.find(last.start, last.goal, kLong).empty();
  }

  struct Last {
    std::shared_ptr<const robot::Surroundings> around;
    robot::JointVector start, goal;
  };
  int pairs_;
  bool with_searches_;
  std::shared_ptr<const scene::Scene> scene_;
  test::CellScript cell_;
  std::unique_ptr<world::CellSurroundings> around_;
  std::vector<robot::JointLimits> limits_;
  std::array<bool, kRobots> moving_{};
  std::array<Last, kRobots> last_;
  std::mt19937_64 random_{49};
  api::Ticket ticket_ = 0;
};

int run(int argc, char** argv) {
  Experiment experiment("free_moves", argc, argv);
  const int pairs = experiment.quick() ? 10 : 1000;
  const int repeated = experiment.quick() ? 4 : 100;
  FreeMoves moves(pairs, true);
  moves.run();
  FreeMoves once(repeated, false), again(repeated, false);
  once.run();
  again.run();

  Table table({"robot", "pairs", "blocked in a straight line", "reached", "refused",
               "by a long search, too", "search p50 [ms]", "search p95 [ms]", "longest [ms]",
               "in vain, p95 [ms]", "length beside the best, p95"});
  Tally all;
  for (std::size_t r = 0; r < kRobots; ++r) {
    const Tally& one = moves.tally[r];
    const auto or_zero = [](const std::vector<double>& samples, double p) {
      return samples.empty() ? 0.0 : percentile(samples, p);
    };
    table.row({r == 0 ? "fanuc" : "motoman", double(one.pairs), double(one.blocked),
               double(one.reached), double(one.refused), double(one.impossible),
               or_zero(one.search_ms, 0.5), or_zero(one.search_ms, 0.95), or_zero(one.search_ms, 1),
               or_zero(one.vain_ms, 0.95), or_zero(one.ratios, 0.95)});
    all.pairs += one.pairs;
    all.reached += one.reached;
    all.refused += one.refused;
    all.impossible += one.impossible;
    all.compared += one.compared;
    all.good += one.good;
    all.search_ms.insert(all.search_ms.end(), one.search_ms.begin(), one.search_ms.end());
  }
  experiment.table("moves", "Both robots between random postures", table);
  experiment.record("free_moves.contacts", double(moves.contacts()), "count");
  experiment.record("free_moves.solved",
                    double(all.reached) / std::max(1, all.reached + all.refused - all.impossible),
                    "share");
  experiment.record("free_moves.search_p95_ms", percentile(all.search_ms, 0.95), "ms");
  experiment.record("free_moves.good_lengths", double(all.good) / std::max(1, all.compared),
                    "share");
  experiment.record("free_moves.differing_hashes", once.hash() == again.hash() ? 0 : 1, "count");
  experiment.note(
      "Goals are random postures over all of the joints' ranges that are free at the moment of the "
      "command. Times are processor times of the search. Joints at full speed, the tool at its "
      "maxima. Both robots plan round each other. A "
      "move that is refused counts as solvable where 20 attempts of 4000 iterations find a path "
      "in the surroundings of its command. Every tenth path that is no straight line is compared "
      "with the shortest of these attempts, 300 shortcuts each.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
