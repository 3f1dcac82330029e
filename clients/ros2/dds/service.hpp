#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "clients/ros2/dds/node.hpp"

namespace aprsim::ros2 {

/// The header before each request and reply, as ROS 2's CycloneDDS writes it.
struct ServiceHeader {
  std::uint64_t client = 0;
  std::int64_t sequence = 0;
};

/// The sender of a request.
struct Caller {
  ServiceHeader header;
  std::string client_id;  ///< as in the user data of the client's reader and writer
};

/// A service of ROS 2. Clients are nodes whose middleware is rmw_cyclonedds_cpp: requests of others
/// have no header and are dropped. Thread: one. Errors of DDS: std::runtime_error.
class Service {
 public:
  /// Writes a reply, whose sample begins with the header.
  using WriteReply = std::function<void(dds_entity_t writer, const ServiceHeader& header)>;

  Service(Node& node, const std::string& name, const TopicType& request, const TopicType& reply);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  [[nodiscard]] dds_entity_t requests() const { return ends_.requests; }

  /// Takes the requests that have come, and tries again to send replies that wait. The samples live
  /// until `serve` returns.
  void take(const std::function<void(const Caller&, const void* sample)>& serve);
  /// Sends a reply, or keeps it until the client's reader is known, for some seconds.
  void reply(const Caller& caller, WriteReply write);

 private:
  struct Waiting {
    Caller caller;
    WriteReply write;
    std::chrono::steady_clock::time_point until;
  };

  [[nodiscard]] std::string client_of(dds_instance_handle_t writer) const;
  [[nodiscard]] bool is_known(const std::string& client_id) const;
  void send_waiting();

  Node& node_;
  ServiceEndpoints ends_;
  std::vector<Waiting> waiting_;
};

}  // namespace aprsim::ros2
