#pragma once

#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <google/protobuf/duration.pb.h>

#include "clients/ros2/dds/node.hpp"
#include "clients/ros2/dds/wakeup.hpp"
#include "clients/wires/endpoints.hpp"

namespace aprsim::ros2 {

/// The services and the action of simulation_interfaces, one request after the other in a thread of
/// its own; its functions may be called by any. Errors of DDS end the thread, and come back by
/// check().
class SimulationServices {
 public:
  /// `ros_namespace`: before the names of the services, "/" = none.
  SimulationServices(Node& node, std::string ros_namespace);
  ~SimulationServices();
  SimulationServices(const SimulationServices&) = delete;
  SimulationServices& operator=(const SimulationServices&) = delete;

  /// The daemon from now on.
  void set_daemon(const client::Endpoints& daemon);
  /// Simulated time of the latest snapshot.
  void set_time(const google::protobuf::Duration& time);
  /// The daemon has gone: requests fail until set_daemon().
  void disconnect();
  /// Throws the error that has ended the thread.
  void check();

 private:
  void run();
  void work();

  Node& node_;
  std::string namespace_;
  Wakeup wakeup_;
  std::mutex mutex_;  ///< of the three below
  std::optional<client::Endpoints> daemon_;
  google::protobuf::Duration now_;
  std::exception_ptr error_;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace aprsim::ros2
