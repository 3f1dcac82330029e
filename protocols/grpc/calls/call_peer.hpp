#pragma once

#include <cstdint>
#include <string>

namespace aprsim::grpc_server {

/// The caller.
struct CallPeer {
  std::string address;           ///< "ADDRESS:PORT" of the client
  std::uint64_t connection = 0;  ///< ConnectionTrace::number(); 0 = it is not traced
};

/// The socket name in gRPC's identifier of a peer: a URI, "SCHEME:" and the percent-encoded name.
/// Thread: any.
[[nodiscard]] std::string socket_name(const std::string& uri);

/// The peer of gRPC's identifier, the socket name that the client's relay has set,
/// "ADDRESS:PORT/SOMETHING.CONNECTION".
/// Thread: any.
[[nodiscard]] CallPeer call_peer(const std::string& uri);

}  // namespace aprsim::grpc_server
