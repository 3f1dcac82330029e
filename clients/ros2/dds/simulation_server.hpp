#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "clients/ros2/dds/service.hpp"
#include "clients/ros2/dds/wakeup.hpp"
#include "clients/ros2/simulation/simulation.hpp"

namespace aprsim::ros2 {

/// The services of simulation_interfaces 2.1 that the cell has. Thread: one. Errors of DDS:
/// std::runtime_error.
class SimulationServer {
 public:
  /// `ros_namespace`: before the names of the services, empty = none.
  SimulationServer(Node& node, const std::string& ros_namespace, const Wakeup& wakeup);

  /// Takes the requests that have come, and answers them; without a simulation they fail.
  void serve(Simulation* simulation);

 private:
  /// A service and what answers its requests.
  struct Entry {
    std::unique_ptr<Service> service;
    std::function<Service::WriteReply(Simulation* simulation, const void* sample)> answer;
  };
  std::vector<Entry> entries_;
};

}  // namespace aprsim::ros2
