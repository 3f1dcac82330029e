#include "protocols/grpc/calls/connected_clients.hpp"

#include <utility>

#include "protocols/grpc/calls/call_peer.hpp"

namespace aprsim::grpc_server {
void ConnectedClients::add(const std::string& name, ConnectedClient client) {
  const std::lock_guard lock(mutex_);
  clients_[name] = std::move(client);
}

void ConnectedClients::remove(const std::string& name) {
  const std::lock_guard lock(mutex_);
  clients_.erase(name);
}

ConnectedClient ConnectedClients::of(const std::string& grpc_peer) const {
  const std::string name = socket_name(grpc_peer);
  const std::lock_guard lock(mutex_);
  const auto found = clients_.find(name);
  if (found != clients_.end()) return found->second;
  return {.peer = name.substr(0, name.find('/'))};
}

}  // namespace aprsim::grpc_server
