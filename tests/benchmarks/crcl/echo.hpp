#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>

namespace aprsim::bench {

/// Round trip time of the machine itself: a thread answers each request of one client with the same
/// prepared bytes, without parsing it.
class Echo {
 public:
  /// Listens at once; answers have `size` bytes and end as a status does.
  explicit Echo(std::size_t size);
  /// Waits for the client to go.
  ~Echo();
  Echo(const Echo&) = delete;
  Echo& operator=(const Echo&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }

 private:
  void serve();

  std::string answer_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::jthread thread_;
};

}  // namespace aprsim::bench
