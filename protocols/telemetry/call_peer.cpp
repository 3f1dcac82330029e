#include "protocols/telemetry/call_peer.hpp"

#include <charconv>
#include <cstddef>

namespace aprsim::telemetry {

CallPeer call_peer(const std::string& uri) {
  CallPeer peer;
  std::size_t i = uri.find(':') + 1;
  for (; i < uri.size() && uri[i] != '/'; ++i) {
    int code = 0;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(&uri[i + 1], &uri[i + 3], code, 16).ptr == &uri[i + 3]) {
      peer.address += static_cast<char>(code);
      i += 2;
    } else {
      peer.address += uri[i];
    }
  }
  const std::size_t number = uri.rfind('.');
  if (number != std::string::npos && number > i) {
    std::from_chars(uri.data() + number + 1, uri.data() + uri.size(), peer.connection);
  }
  return peer;
}

}  // namespace aprsim::telemetry
