#pragma once

#include "clients/ros2/cameras/camera_publisher.hpp"
#include "clients/ros2/cameras/tray_publisher.hpp"
#include "clients/ros2/publisher.hpp"
#include "clients/ros2/simulation_services.hpp"
#include "clients/ros2/trajectory_actions.hpp"
#include "clients/wires/cancellation.hpp"
#include "clients/wires/endpoints.hpp"

namespace aprsim::ros2 {

/// The daemon to read, and how often.
struct BridgeOptions {
  client::EndpointChoice endpoints;
  double rate_hz = 100;    ///< time and joints, by the wall clock
  double tf_rate_hz = 20;  ///< moving frames, at most the rate above
};

/// The parts of the node that have a cell.
struct BridgeParts {
  CellPublisher& publisher;
  CameraPublisher& cameras;
  TrayPublisher& trays;
  TrajectoryActions& actions;
  SimulationServices& services;
};

/// Publishes the daemon's cell, and serves its actions and services, until cancelled. A daemon that
/// goes away is reported and tried again each second. One line on standard output tells each
/// connection. Failures: kUsage, for endpoints that are wrong at the start. Throws
/// std::runtime_error if DDS fails.
[[nodiscard]] client::Outcome<void> run_bridge(const BridgeOptions& options,
                                               const BridgeParts& parts,
                                               const client::Cancelled& cancelled);

}  // namespace aprsim::ros2
