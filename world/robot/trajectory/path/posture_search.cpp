#include "world/robot/trajectory/path/posture_search.hpp"

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
/// The same for the elbow angle. Three joints move the elbow: much more than this would move one of
/// them too far.
constexpr double kLongestElbowStep_rad = 0.45;
/// Weights of closeness to limits and to singular postures, against joint motion in joint ranges.
constexpr double kCrowdingWeight = 0.2, kSingularWeight = 2e-4, kLeastDexterity = 1e-4;
constexpr double kUnreached = std::numeric_limits<double>::infinity(), kUnknown = -1;

double range_of(const Joint& joint) { return joint.upper_rad - joint.lower_rad; }

}  // namespace

PostureSearch::PostureSearch(const ArmGeometry& arm, const ToolPath& tool,
                             const Eigen::Isometry3d& X_TF)
    : arm_(arm), tool_(tool), X_TF_(X_TF), layers_(count_layers()) {}

/// Number of layers, by the tool's travel and rotation.
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

double PostureSearch::posture_cost(const JointVector& q) const {
  double crowding = 0;
  for (int i = 0; i < arm_.model.dof(); ++i) {
    const Joint& joint = arm_.model.joints[static_cast<std::size_t>(i)];
    // An eighth power is flat over most of the range and steep at its ends.
    const double place = (2 * q(i) - joint.lower_rad - joint.upper_rad) / range_of(joint);
    const double fourth = place * place * place * place;
    crowding += fourth * fourth;
  }
  return kCrowdingWeight * crowding +
         kSingularWeight / (kLeastDexterity + dexterity(arm_.model, q));
}

std::vector<PostureSearch::Node> PostureSearch::nodes_at(std::size_t index, double elbow) const {
  const double length = tool_.segments().length();
  const double s = index == layers_
                       ? length
                       : static_cast<double>(index) / static_cast<double>(layers_) * length;
  std::vector<Node> nodes;
  for (const IkSolution& solution : arm_.ik.all(tool_.at(s) * X_TF_, elbow)) {
    nodes.push_back({solution.q, kUnknown, kUnreached, nullptr});
  }
  return nodes;
}

bool PostureSearch::forbidden(std::size_t index, const JointVector& from,
                              const JointVector& to) const {
  return std::any_of(forbidden_.begin(), forbidden_.end(), [&](const Step& step) {
    return step.index == index && step.from == from && step.to == to;
  });
}

/// The cheapest way to a node from those of one elbow angle of the layer before. The costs
/// approximate the integrals over u of the squared joint speed and of the discomfort.
void PostureSearch::reach(Node& node, std::size_t index, const Nodes& before) const {
  const auto count = static_cast<double>(layers_);
  for (const Node& from : before.nodes) {
    if (from.total == kUnreached) continue;
    double way = 0;
    bool near = true;
    for (int i = 0; i < arm_.model.dof() && near; ++i) {
      const double step = node.q(i) - from.q(i);
      near = std::abs(step) < kLongestStep_rad;
      const double share = step / range_of(arm_.model.joints[static_cast<std::size_t>(i)]);
      way += share * share;
    }
    if (!near) continue;
    if (node.cost == kUnknown) node.cost = posture_cost(node.q);
    const double total = from.total + way * count + node.cost / count;
    if (total < node.total && !forbidden(index, from.q, node.q)) {
      node.total = total;
      node.from = &from;
    }
  }
}

bool PostureSearch::connect(std::size_t index, double first_elbow) {
  const Layer& before = graph_[index - 1];
  Layer& layer = graph_[index];
  const auto angles = static_cast<int>(layer.size());
  const double angle = 2 * std::numbers::pi / angles;
  // Dynamic programming layer by layer (Bellman 1957): a node's cost is final once its layer is
  // connected. The window makes the work linear in the number of elbow angles.
  const int window = std::min(static_cast<int>(kLongestElbowStep_rad / angle), (angles - 1) / 2);
  std::vector<const Nodes*> near;
  bool reached = false;
  for (int k = 0; k < angles; ++k) {
    near.clear();
    for (int j = k - window; j <= k + window; ++j) {
      const Nodes& nodes = before[static_cast<std::size_t>((j + angles) % angles)];
      if (std::any_of(nodes.nodes.begin(), nodes.nodes.end(),
                      [](const Node& node) { return node.total < kUnreached; })) {
        near.push_back(&nodes);
      }
    }
    Nodes& here = layer[static_cast<std::size_t>(k)];
    // Inverse kinematics is evaluated lazily: postures that cannot be reached are never computed.
    if (!near.empty() && !here.known) here = {nodes_at(index, first_elbow + angle * k), true};
    for (Node& node : here.nodes) {
      node.total = kUnreached;
      for (const Nodes* nodes : near) reach(node, index, *nodes);
      reached = reached || node.total < kUnreached;
    }
  }
  return reached;
}

std::vector<JointVector> PostureSearch::find(const JointVector& start, int elbow_angles) {
  found_.clear();
  // The start's own elbow angle is one of those to try: keeping it is one of the ways.
  const double first_elbow = arm_.ik.elbow_of(start);
  const auto angles = static_cast<std::size_t>(elbow_angles);
  if (graph_.empty() || graph_.front().size() != angles) {
    graph_.assign(layers_ + 1, Layer(angles));
    graph_.front().front() = {{Node{start, 0, 0, nullptr}}, true};
  }
  for (std::size_t i = 1; i <= layers_; ++i) {
    if (arm_.cancelled() || !connect(i, first_elbow)) return {};
  }
  // Back from the cheapest end.
  const Node* at = nullptr;
  for (const Nodes& nodes : graph_.back()) {
    for (const Node& node : nodes.nodes) {
      if (node.total < (at == nullptr ? kUnreached : at->total)) at = &node;
    }
  }
  found_.resize(layers_ + 1);
  for (std::size_t i = layers_ + 1; i-- > 0; at = at->from) found_[i] = at->q;
  return found_;
}

void PostureSearch::forbid(double u) {
  if (found_.empty()) return;
  const auto index =
      std::min(layers_, static_cast<std::size_t>(u * static_cast<double>(layers_)) + 1);
  forbidden_.push_back({index, found_[index - 1], found_[index]});
}

}  // namespace aprsim::robot
