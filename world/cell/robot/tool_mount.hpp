#pragma once

#include <Eigen/Geometry>

namespace aprsim::world {

/// The tool on a flange, and the pose of its mount M: at the flange F, or on the way there after
/// the lock has met the tool within its capture range. A copyable value. Thread: sim.
class ToolMount {
 public:
  /// `tool`: index among the scene's tools, -1 = none.
  ToolMount(int tool, const Eigen::Isometry3d& X_WF) : X_WM_(X_WF), tool_(tool) {}

  /// The tool changer has locked `tool`, whose mount is at `X_WM`.
  void couple(int tool, const Eigen::Isometry3d& X_WM);
  void release();
  /// One step; the tool is drawn to the flange in equal steps.
  void step(const Eigen::Isometry3d& X_WF);

  [[nodiscard]] int tool() const { return tool_; }
  [[nodiscard]] bool has_tool() const { return tool_ >= 0; }
  [[nodiscard]] const Eigen::Isometry3d& X_WM() const { return X_WM_; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [X_WM, pull_steps, tool] = self;
    io(X_WM, pull_steps, tool);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.index_or_none(In::kTool, tool_);
  }

 private:
  Eigen::Isometry3d X_WM_;
  int pull_steps_ = 0;  ///< until the tool is at the flange
  int tool_;
};

}  // namespace aprsim::world
