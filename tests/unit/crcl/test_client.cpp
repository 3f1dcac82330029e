#include "tests/unit/crcl/test_client.hpp"

#include <arpa/inet.h>
#include <cerrno>
#include <cstring>
#include <netinet/in.h>
#include <optional>
#include <poll.h>
#include <stdexcept>
#include <sys/socket.h>
#include <unistd.h>

#include "crcl/schema.hpp"
#include "crcl/status_decoder.hpp"
#include "tests/unit/crcl/samples.hpp"

namespace aprsim::protocols {
namespace {

constexpr int kPatienceMs = 10'000;

}  // namespace

void TestClient::fail(const std::string& what) { throw std::runtime_error("TestClient: " + what); }

TestClient::TestClient(std::uint16_t port, int receive_buffer)
    : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
  if (receive_buffer > 0) {
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
  }
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    fail(std::strerror(errno));
  }
}

TestClient::~TestClient() {
  if (fd_ >= 0) ::close(fd_);
}

void TestClient::send(std::string_view bytes) {
  while (!bytes.empty()) {
    pollfd writable{fd_, POLLOUT, 0};
    if (::poll(&writable, 1, kPatienceMs) != 1) fail("the server does not read");
    const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0) fail(std::string("send: ") + std::strerror(errno));
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

void TestClient::command(std::int64_t id, const std::string& type, const std::string& body) {
  send(crcl::instance(type, "<CommandID>" + std::to_string(id) + "</CommandID>" + body));
}

crcl::Status TestClient::status() {
  command(999, "GetStatusType");
  return read_status();
}

crcl::Status TestClient::read_status() {
  const std::string document = read_document();
  const crcl::Result<crcl::Status> status = crcl::decode_status(document);
  if (!status) fail(status.error().message() + ": " + document);
  return *status;
}

std::string TestClient::read_document() {
  while (true) {
    const crcl::Result<std::optional<std::string>> document = framer_.next();
    if (!document) fail(document.error().message());
    if (*document) {
      if (const auto fault = crcl::schema_fault(**document)) {
        fail(fault->message() + ": " + **document);
      }
      return **document;
    }
    char buffer[4096];
    const std::size_t size = receive(buffer, sizeof buffer);
    if (size == 0) fail("closed while a status was expected");
    framer_.append({buffer, size});
  }
}

std::size_t TestClient::receive(char* buffer, std::size_t size) {
  pollfd readable_fd{fd_, POLLIN, 0};
  if (::poll(&readable_fd, 1, kPatienceMs) != 1) fail("no answer");
  const ssize_t received = ::recv(fd_, buffer, size, 0);
  if (received < 0 && errno == ECONNRESET) return 0;
  if (received < 0) fail(std::string("recv: ") + std::strerror(errno));
  return static_cast<std::size_t>(received);
}

void TestClient::finish_sending() { ::shutdown(fd_, SHUT_WR); }

void TestClient::expect_closed() {
  char buffer[4096];
  if (receive(buffer, sizeof buffer) != 0) fail("got bytes where the end was expected");
}

bool TestClient::readable(std::chrono::milliseconds wait) {
  pollfd readable_fd{fd_, POLLIN, 0};
  return ::poll(&readable_fd, 1, static_cast<int>(wait.count())) == 1;
}

void TestClient::reset() {
  const linger hard{1, 0};
  ::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
  ::close(fd_);
  fd_ = -1;
}

}  // namespace aprsim::protocols
