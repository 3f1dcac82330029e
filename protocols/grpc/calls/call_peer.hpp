#pragma once

#include <cstdint>
#include <string>

namespace aprsim::grpc_server {

/// The caller.
struct CallPeer {
  std::string address;           ///< "ADDRESS:PORT" of the client
  std::uint64_t connection = 0;  ///< ConnectionTrace::number(); 0 = it is not traced
};

/// The name of the socket that gRPC calls a peer by: an URI, "SCHEME:" and the name with some signs
/// as %XX. Thread: any.
[[nodiscard]] std::string socket_name(const std::string& uri);

/// The peer by gRPC's name for it, the socket name that the client's relay has given itself,
/// "ADDRESS:PORT/SOMETHING.CONNECTION".
/// Thread: any.
[[nodiscard]] CallPeer call_peer(const std::string& uri);

}  // namespace aprsim::grpc_server
