// A node of ROS 2 beside the daemon: reads the cell by gRPC, publishes it by DDS.

#include <atomic>
#include <csignal>
#include <exception>
#include <iostream>

#include "clients/ros2/bridge.hpp"
#include "clients/ros2/cameras/camera_publisher.hpp"
#include "clients/ros2/cameras/tray_publisher.hpp"
#include "clients/ros2/dds/node.hpp"
#include "clients/ros2/options.hpp"
#include "clients/ros2/simulation_services.hpp"
#include "clients/ros2/trajectory_actions.hpp"

namespace {

std::atomic<bool> stop_requested = false;
static_assert(std::atomic<bool>::is_always_lock_free);

/// The first signal asks for the end, a second one ends the process at once.
extern "C" void on_signal(int signal) {
  stop_requested = true;
  std::signal(signal, SIG_DFL);
}

int run(const aprsim::ros2::Options& options) {
  aprsim::ros2::Node node(options.domain, options.ros_namespace, "aprsim");
  aprsim::ros2::CellPublisher publisher(node, options.ros_namespace);
  aprsim::ros2::CameraPublisher cameras(node, options.ros_namespace, publisher.frames());
  aprsim::ros2::TrayPublisher trays(node, options.ros_namespace, publisher.frames());
  aprsim::ros2::TrajectoryActions actions(node, options.ros_namespace);
  aprsim::ros2::SimulationServices services(node, options.ros_namespace);
  const auto done =
      aprsim::ros2::run_bridge(options.bridge, {publisher, cameras, trays, actions, services},
                               [] { return stop_requested.load(); });
  if (done) return 0;
  std::cerr << "aprsim-ros2: " << done.error().message << '\n';
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  int exit_code = 0;
  const auto options = aprsim::ros2::parse_options(argc, argv, exit_code);
  if (!options) return exit_code;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  try {
    return run(*options);
  } catch (const std::exception& error) {
    std::cerr << "aprsim-ros2: " << error.what() << '\n';
    return 1;
  }
}
