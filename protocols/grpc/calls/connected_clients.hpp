#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "protocols/access/access.hpp"

namespace aprsim::grpc_server {

/// The client behind one of gRPC's connections.
struct ConnectedClient {
  std::string peer;                                                      ///< "ADDRESS:PORT"
  std::shared_ptr<const protocols::ClientCertificate> certificate = {};  ///< null = none
};

/// Registry of the clients behind gRPC's connections, which end in the relays. gRPC knows the names
/// of the sockets only. Thread: any.
class ConnectedClients {
 public:
  /// `name` of the socket that gRPC sees.
  void add(const std::string& name, ConnectedClient client);
  void remove(const std::string& name);
  /// The client of gRPC's identifier of a peer; one that has just disconnected has its name only.
  [[nodiscard]] ConnectedClient of(const std::string& grpc_peer) const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, ConnectedClient, std::less<>> clients_;
};

}  // namespace aprsim::grpc_server
