#include "world/cell/robot/tool_mount.hpp"

namespace aprsim::world {
namespace {

/// The tool changer draws a tool in during these.
constexpr int kPullSteps = 100;

}  // namespace

void ToolMount::couple(int tool, const Eigen::Isometry3d& X_WM) {
  tool_ = tool;
  pull_steps_ = kPullSteps;
  X_WM_ = X_WM;
}

void ToolMount::release() {
  tool_ = -1;
  pull_steps_ = 0;
}

void ToolMount::step(const Eigen::Isometry3d& X_WF) {
  if (pull_steps_ == 0) {
    X_WM_ = X_WF;
    return;
  }
  const double share = 1.0 / pull_steps_--;
  const Eigen::Quaterniond from(X_WM_.linear()), to(X_WF.linear());
  X_WM_.translation() += share * (X_WF.translation() - X_WM_.translation());
  X_WM_.linear() = from.slerp(share, to).toRotationMatrix();
}

}  // namespace aprsim::world
