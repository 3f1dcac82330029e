#include "world/robot/trajectory/posture_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/kinematics/pose_projection.hpp"

namespace aprsim::robot {
namespace {

/// Distances between two layers of postures, and how many there are.
constexpr double kLayer_m = 0.01, kLayer_rad = 0.05;
constexpr std::size_t kFewestLayers = 24, kMostLayers = 400;
constexpr std::size_t kTravelSamples = 400;
/// Longest way of a joint from layer to layer: postures farther apart are not neighbours [rad].
constexpr double kLongestStep_rad = 0.35;
/// Of closeness to limits and to singular postures against joint motion in joint ranges.
constexpr double kCrowdingWeight = 0.2, kSingularWeight = 2e-4, kLeastDexterity = 1e-4;
constexpr double kUnreached = std::numeric_limits<double>::infinity();

double range_of(const Joint& joint) { return joint.upper_rad - joint.lower_rad; }

}  // namespace

PostureSearch::PostureSearch(const ArmGeometry& arm, const ToolPath& tool,
                             const Eigen::Isometry3d& X_TF)
    : arm_(arm), tool_(tool), X_TF_(X_TF), layers_(count_layers()) {}

/// By the tool's travel and turn.
std::size_t PostureSearch::count_layers() const {
  double travel = 0, turn = 0;
  const double length = tool_.segments().length();
  Eigen::Isometry3d last = tool_.at(0);
  for (std::size_t i = 1; i <= kTravelSamples; ++i) {
    const Eigen::Isometry3d X_BT =
        tool_.at(static_cast<double>(i) / static_cast<double>(kTravelSamples) * length);
    travel += (X_BT.translation() - last.translation()).norm();
    turn += Eigen::AngleAxisd(last.linear().transpose() * X_BT.linear()).angle();
    last = X_BT;
  }
  const double layers = std::ceil(std::max(travel / kLayer_m, turn / kLayer_rad));
  return std::clamp(static_cast<std::size_t>(layers), kFewestLayers, kMostLayers);
}

double PostureSearch::discomfort(const JointVector& q) const {
  double crowding = 0;
  for (int i = 0; i < arm_.model.dof(); ++i) {
    const Joint& joint = arm_.model.joints[static_cast<std::size_t>(i)];
    const double place = (2 * q(i) - joint.lower_rad - joint.upper_rad) / range_of(joint);
    crowding += std::pow(place, 8);
  }
  return kCrowdingWeight * crowding +
         kSingularWeight / (kLeastDexterity + dexterity(arm_.model, q));
}

PostureSearch::Layer PostureSearch::nodes_at(double u, double first_elbow, int elbow_angles) const {
  const double length = tool_.segments().length();
  const Eigen::Isometry3d X_BF = tool_.at(u >= 1 ? length : u * length) * X_TF_;
  Layer layer;
  for (int i = 0; i < elbow_angles; ++i) {
    const double elbow = first_elbow + 2 * std::numbers::pi * i / elbow_angles;
    for (const IkSolution& solution : arm_.ik.all(X_BF, elbow)) {
      layer.push_back({solution.q, discomfort(solution.q), kUnreached, 0});
    }
  }
  return layer;
}

bool PostureSearch::forbidden(std::size_t index, const JointVector& from,
                              const JointVector& to) const {
  return std::any_of(forbidden_.begin(), forbidden_.end(), [&](const Step& step) {
    return step.index == index && step.from == from && step.to == to;
  });
}

/// The cheapest way to each node of a layer. The costs approximate the integrals over u of the
/// squared joint speed and of the discomfort.
void PostureSearch::connect(const Layer& before, Layer& layer, std::size_t index) const {
  const auto count = static_cast<double>(layers_);
  std::vector<std::size_t> reached;
  for (std::size_t k = 0; k < before.size(); ++k) {
    if (before[k].total < kUnreached) reached.push_back(k);
  }
  for (Node& node : layer) {
    node.total = kUnreached;
    for (const std::size_t k : reached) {
      const Node& from = before[k];
      double way = 0;
      bool near = true;
      for (int i = 0; i < arm_.model.dof() && near; ++i) {
        const double step = node.q(i) - from.q(i);
        near = std::abs(step) < kLongestStep_rad;
        const double share = step / range_of(arm_.model.joints[static_cast<std::size_t>(i)]);
        way += share * share;
      }
      if (!near) continue;
      const double total = from.total + way * count + node.cost / count;
      if (total < node.total && !forbidden(index, from.q, node.q)) {
        node.total = total;
        node.from = k;
      }
    }
  }
}

std::vector<JointVector> PostureSearch::find(const JointVector& start, int elbow_angles) {
  found_.clear();
  // The start's own elbow angle is one of those to try: keeping it is one of the ways.
  const double first_elbow = arm_.ik.elbow_of(start);
  const bool known = elbow_angles == elbow_angles_;
  if (!known) graph_.assign(1, {Node{start, 0, 0, 0}});
  elbow_angles_ = elbow_angles;
  for (std::size_t i = 1; i <= layers_; ++i) {
    if (arm_.cancelled()) return {};
    if (!known || graph_.size() <= i) {
      graph_.push_back(nodes_at(static_cast<double>(i) / static_cast<double>(layers_), first_elbow,
                                elbow_angles));
    }
    connect(graph_[i - 1], graph_[i], i);
    const bool reached = std::any_of(graph_[i].begin(), graph_[i].end(),
                                     [](const Node& node) { return node.total < kUnreached; });
    if (!reached) return {};
  }
  // Back from the cheapest end.
  const Layer& end = graph_.back();
  const auto best = std::min_element(
      end.begin(), end.end(), [](const Node& a, const Node& b) { return a.total < b.total; });
  if (best == end.end() || best->total == kUnreached) return {};
  found_.resize(layers_ + 1);
  auto at = static_cast<std::size_t>(best - end.begin());
  for (std::size_t i = layers_ + 1; i-- > 0;) {
    found_[i] = graph_[i][at].q;
    at = graph_[i][at].from;
  }
  return found_;
}

void PostureSearch::forbid(double u) {
  if (found_.empty()) return;
  const auto index =
      std::min(layers_, static_cast<std::size_t>(u * static_cast<double>(layers_)) + 1);
  forbidden_.push_back({index, found_[index - 1], found_[index]});
}

}  // namespace aprsim::robot
