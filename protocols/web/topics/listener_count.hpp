#pragma once

#include <cstdint>
#include <string>

namespace aprsim::web {

/// One listener of the daemon, as the page shows it.
struct ListenerCount {
  std::string name;
  std::uint16_t port = 0;
  std::uint64_t clients = 0;
};

}  // namespace aprsim::web
