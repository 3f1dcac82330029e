#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "world/robot/trajectory/path/ik_path.hpp"

namespace aprsim::robot {

/// Finds the postures with which a redundant arm follows a tool path: elbow angles all round the
/// circle, every branch and every full turn within limits at even distances on the path, and
/// through them the cheapest sequence: least joint motion, away from limits and from singular
/// postures. Only postures that can be reached from the start are computed. Dynamic programming
/// over the redundancy (Pashkevich, Dolgui & Chumakov 2004; Ferrentino & Chiacchio 2020).
/// Allocates: for planning only. Thread: any, one at a time.
class PostureSearch {
 public:
  /// The arguments must outlive the search. `X_TF`: the flange in the tool's frame.
  PostureSearch(const ArmGeometry& arm, const ToolPath& tool, const Eigen::Isometry3d& X_TF);

  /// Postures at even distances of u = 0 .. 1, the first one `start`; empty where there is none.
  [[nodiscard]] std::vector<JointVector> find(const JointVector& start, int elbow_angles);
  /// Excludes the step of the last result that contains `u`.
  void forbid(double u);

 private:
  struct Node {
    JointVector q;
    double cost = 0;             ///< of the posture; negative until computed
    double total = 0;            ///< from the start; infinite where it cannot be reached
    const Node* from = nullptr;  ///< of the layer before
  };
  /// Postures of one elbow angle.
  struct Nodes {
    std::vector<Node> nodes;
    bool known = false;
  };
  /// Nodes by elbow angle.
  using Layer = std::vector<Nodes>;

  [[nodiscard]] std::size_t count_layers() const;
  [[nodiscard]] std::vector<Node> nodes_at(std::size_t index, double elbow) const;
  /// Whether any node of layer `index` is reached.
  bool connect(std::size_t index, double first_elbow);
  void reach(Node& node, std::size_t index, const Nodes& before) const;
  [[nodiscard]] bool forbidden(std::size_t index, const JointVector& from,
                               const JointVector& to) const;
  [[nodiscard]] double posture_cost(const JointVector& q) const;

  struct Step {
    std::size_t index;
    JointVector from, to;
  };

  const ArmGeometry& arm_;
  const ToolPath& tool_;
  Eigen::Isometry3d X_TF_;
  std::size_t layers_;  ///< besides the start
  std::vector<Layer> graph_;
  std::vector<JointVector> found_;
  std::vector<Step> forbidden_;
};

}  // namespace aprsim::robot
