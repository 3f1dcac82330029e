#include "protocols/grpc/calls/call_peer.hpp"

#include <charconv>
#include <cstddef>

namespace aprsim::grpc_server {

std::string socket_name(const std::string& uri) {
  std::string name;
  for (std::size_t i = uri.find(':') + 1; i < uri.size(); ++i) {
    int code = 0;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(&uri[i + 1], &uri[i + 3], code, 16).ptr == &uri[i + 3]) {
      name += static_cast<char>(code);
      i += 2;
    } else {
      name += uri[i];
    }
  }
  return name;
}

CallPeer call_peer(const std::string& uri) {
  const std::string name = socket_name(uri);
  const std::size_t end = name.find('/');
  CallPeer peer{.address = name.substr(0, end)};
  const std::size_t number = name.rfind('.');
  if (number != std::string::npos && end != std::string::npos && number > end) {
    std::from_chars(name.data() + number + 1, name.data() + name.size(), peer.connection);
  }
  return peer;
}

}  // namespace aprsim::grpc_server
