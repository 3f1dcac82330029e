#include "tests/benchmarks/crcl/echo.hpp"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <stdexcept>
#include <string_view>
#include <sys/socket.h>
#include <unistd.h>

namespace aprsim::bench {
namespace {

constexpr std::string_view kStatusEnd = "</CRCLStatus>";

}  // namespace

Echo::Echo(std::size_t size) : answer_(size, ' ') {
  answer_.replace(size - kStatusEnd.size(), kStatusEnd.size(), kStatusEnd);
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), length) != 0 ||
      ::listen(listener_, 1) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
    throw std::runtime_error("cannot listen");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::jthread([this] { serve(); });
}

Echo::~Echo() {
  thread_.join();
  ::close(listener_);
}

void Echo::serve() {
  const int fd = ::accept(listener_, nullptr, nullptr);
  const int on = 1;
  ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  char bytes[4096];
  while (::recv(fd, bytes, sizeof bytes, 0) > 0) {
    if (::send(fd, answer_.data(), answer_.size(), MSG_NOSIGNAL) < 0) break;
  }
  ::close(fd);
}

}  // namespace aprsim::bench
