#include "world/robot/avoidance/path_search.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <ompl/base/MotionValidator.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateSampler.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <random>
#include <utility>

namespace aprsim::robot {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

constexpr double kLeastLever_m = 0.05;
/// Longest motion that is added to a tree [m].
constexpr double kRange_m = 0.8;
/// Share of the samples near the ends of the move, and how near.
constexpr double kNearShare = 0.5, kNear_rad = 0.7;
constexpr double kLeastGain_m = 1e-3;
constexpr double kSame_rad = 1e-9;

/// Uniform numbers of one generator. The standard's distributions differ between libraries.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : engine_(seed) {}
  /// In [0, 1).
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }

 private:
  std::mt19937_64 engine_;
};

/// Joint vectors as states of OMPL, each joint times its weight.
struct Scaling {
  JointVector weights;

  [[nodiscard]] JointVector posture(const ob::State* state) const {
    const double* values = state->as<ob::RealVectorStateSpace::StateType>()->values;
    JointVector q(weights.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) q(i) = values[i] / weights(i);
    return q;
  }
  void write(const JointVector& q, ob::State* state) const {
    double* values = state->as<ob::RealVectorStateSpace::StateType>()->values;
    for (Eigen::Index i = 0; i < q.size(); ++i) values[i] = q(i) * weights(i);
  }
};

/// Samples with numbers of its own: OMPL's generators are seeded by the process.
class Sampler final : public ob::StateSampler {
 public:
  Sampler(const ob::StateSpace* space, Scaling scaling, const JointLimits& limits,
          const JointVector& start, const JointVector& goal, std::uint64_t seed)
      : StateSampler(space), scaling_(std::move(scaling)), limits_(limits), numbers_(seed) {
    near_low_ = (start.cwiseMin(goal).array() - kNear_rad).matrix().cwiseMax(limits.lower);
    near_high_ = (start.cwiseMax(goal).array() + kNear_rad).matrix().cwiseMin(limits.upper);
  }

  void sampleUniform(ob::State* state) override {
    const bool near = numbers_.unit() < kNearShare;
    const JointVector& low = near ? near_low_ : limits_.lower;
    const JointVector& high = near ? near_high_ : limits_.upper;
    JointVector q(low.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) q(i) = numbers_.between(low(i), high(i));
    scaling_.write(q, state);
  }
  void sampleUniformNear(ob::State* state, const ob::State*, double) override {
    sampleUniform(state);
  }
  void sampleGaussian(ob::State* state, const ob::State*, double) override { sampleUniform(state); }

 private:
  Scaling scaling_;
  const JointLimits& limits_;
  JointVector near_low_, near_high_;
  Numbers numbers_;
};

class PostureValidity final : public ob::StateValidityChecker {
 public:
  PostureValidity(const ob::SpaceInformationPtr& space, CollisionChecker& checker, Scaling scaling)
      : StateValidityChecker(space), checker_(checker), scaling_(std::move(scaling)) {}
  bool isValid(const ob::State* state) const override {
    return checker_.is_free(scaling_.posture(state));
  }

 private:
  CollisionChecker& checker_;
  Scaling scaling_;
};

class MotionValidity final : public ob::MotionValidator {
 public:
  MotionValidity(const ob::SpaceInformationPtr& space, CollisionChecker& checker, Scaling scaling)
      : MotionValidator(space), checker_(checker), scaling_(std::move(scaling)) {}
  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    return checker_.is_free(scaling_.posture(from), scaling_.posture(to));
  }
  bool checkMotion(const ob::State* from, const ob::State* to,
                   std::pair<ob::State*, double>& last) const override {
    last.second = 0;
    return checkMotion(from, to);
  }

 private:
  CollisionChecker& checker_;
  Scaling scaling_;
};

/// Its messages are no part of the daemon's log.
void silence_ompl() {
  static std::once_flag once;
  std::call_once(once, [] { ompl::msg::noOutputHandler(); });
}

}  // namespace

PathSearch::PathSearch(CollisionChecker& checker, const JointLimits& limits,
                       const std::atomic<bool>* cancelled)
    : checker_(checker),
      limits_(limits),
      cancelled_(cancelled),
      weights_(checker.levers().cwiseMax(kLeastLever_m)) {}

double PathSearch::distance(const JointVector& a, const JointVector& b) const {
  return (a - b).cwiseProduct(weights_).norm();
}

double PathSearch::length(const std::vector<JointVector>& path) const {
  double sum = 0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += distance(path[i - 1], path[i]);
  return sum;
}

std::vector<JointVector> PathSearch::find(const JointVector& start, const JointVector& goal,
                                          const PathSearchEffort& effort) {
  if (checker_.is_free(start, goal)) return {start, goal};
  last_evaluation_ = checker_.evaluations() + effort.evaluations;
  std::vector<JointVector> best;
  for (int i = 0; i < effort.attempts && !ended(); ++i) {
    const std::uint64_t seed = effort.seed + 1000003 * static_cast<std::uint64_t>(i);
    std::vector<JointVector> path = connect(start, goal, effort.iterations, seed);
    if (path.empty()) continue;
    shorten(path, effort.shortcuts, seed);
    if (best.empty() || length(path) < length(best)) best = std::move(path);
    // No path is shorter than the straight line.
    if (length(best) <= effort.good_length * distance(start, goal)) break;
  }
  return best;
}

/// Whether its effort is spent, or nobody waits for it.
bool PathSearch::ended() const {
  return checker_.evaluations() > last_evaluation_ ||
         (cancelled_ != nullptr && cancelled_->load(std::memory_order_relaxed));
}

std::vector<JointVector> PathSearch::connect(const JointVector& start, const JointVector& goal,
                                             int iterations, std::uint64_t seed) {
  silence_ompl();
  const Scaling scaling{weights_};
  const auto dof = static_cast<unsigned>(start.size());
  auto space = std::make_shared<ob::RealVectorStateSpace>(dof);
  ob::RealVectorBounds bounds(dof);
  for (unsigned i = 0; i < dof; ++i) {
    bounds.setLow(i, limits_.lower(i) * weights_(i));
    bounds.setHigh(i, limits_.upper(i) * weights_(i));
  }
  space->setBounds(bounds);
  space->setStateSamplerAllocator([&](const ob::StateSpace* of) {
    return std::make_shared<Sampler>(of, scaling, limits_, start, goal, seed);
  });
  auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker(
      std::make_shared<PostureValidity>(information, checker_, scaling));
  information->setMotionValidator(std::make_shared<MotionValidity>(information, checker_, scaling));
  information->setup();
  auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<> from(space), to(space);
  scaling.write(start, from.get());
  scaling.write(goal, to.get());
  problem->setStartAndGoalStates(from, to);
  og::RRTConnect planner(information);
  planner.setRange(kRange_m);
  // The default structure for neighbours draws numbers of the process's seed.
  planner.setNearestNeighbors<ompl::NearestNeighborsLinear>();
  planner.setProblemDefinition(problem);
  planner.setup();
  int left = iterations;
  const ob::PlannerTerminationCondition ends([&] { return left-- <= 0 || ended(); });
  if (planner.solve(ends) != ob::PlannerStatus::EXACT_SOLUTION) return {};
  std::vector<JointVector> path;
  auto* found = problem->getSolutionPath()->as<og::PathGeometric>();
  for (const ob::State* state : found->getStates()) path.push_back(scaling.posture(state));
  // Exactly, without the rounding of the weights.
  path.front() = start;
  path.back() = goal;
  return path;
}

// ---- shorter paths

/// Straight pieces between two random places of the path, where they are free (Geraerts & Overmars
/// 2007), and postures left out.
void PathSearch::shorten(std::vector<JointVector>& path, int tries, std::uint64_t seed) {
  drop_postures(path);
  Numbers numbers(seed ^ 0x9e3779b97f4a7c15ULL);
  for (int i = 0; i < tries && path.size() > 2 && !ended(); ++i) {
    const PostureCurve curve(path);
    // Places by distance, so that long pieces are met as often as they are long.
    const auto place = [&](double share) {
      double left = share * length(path);
      for (std::size_t k = 1; k < path.size(); ++k) {
        const double piece = distance(path[k - 1], path[k]);
        if (left <= piece && piece > 0) return static_cast<double>(k - 1) + left / piece;
        left -= piece;
      }
      return curve.length();
    };
    double u = place(numbers.unit()), v = place(numbers.unit());
    if (u > v) std::swap(u, v);
    const auto first = static_cast<std::size_t>(u);
    const auto last = static_cast<std::size_t>(std::ceil(v));
    if (last - first < 2) continue;
    const JointVector a = curve.at(u), b = curve.at(v);
    std::vector<JointVector> shorter(path.begin(),
                                     path.begin() + static_cast<std::ptrdiff_t>(first) + 1);
    if ((a - shorter.back()).cwiseAbs().maxCoeff() > kSame_rad) shorter.push_back(a);
    if ((b - path[last]).cwiseAbs().maxCoeff() > kSame_rad) shorter.push_back(b);
    shorter.insert(shorter.end(), path.begin() + static_cast<std::ptrdiff_t>(last), path.end());
    if (length(shorter) > length(path) - kLeastGain_m || !checker_.is_free(a, b)) continue;
    path = std::move(shorter);
  }
  drop_postures(path);
}

void PathSearch::drop_postures(std::vector<JointVector>& path) {
  for (std::size_t i = 1; i + 1 < path.size();) {
    if (checker_.is_free(path[i - 1], path[i + 1])) {
      path.erase(path.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
}

}  // namespace aprsim::robot
