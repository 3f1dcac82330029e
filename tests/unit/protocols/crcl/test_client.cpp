#include "tests/unit/protocols/crcl/test_client.hpp"

#include <optional>
#include <stdexcept>

#include "crcl/schema.hpp"
#include "crcl/status_codec.hpp"
#include "tests/unit/crcl/samples.hpp"

namespace aprsim::crcl_server {
namespace {

constexpr std::chrono::seconds kPatience{10};

}  // namespace

void TestClient::fail(const std::string& what) { throw std::runtime_error("TestClient: " + what); }

void TestClient::send(std::string_view bytes) {
  if (!socket_.send(bytes)) fail("the server has closed or does not read");
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
    const std::string bytes = receive();
    if (bytes.empty()) fail("closed while a status was expected");
    framer_.append(bytes);
  }
}

std::string TestClient::receive() {
  return socket_.receive(std::chrono::steady_clock::now() + kPatience);
}

void TestClient::expect_closed() {
  if (!receive().empty()) fail("got bytes where the end was expected");
}

bool TestClient::readable(std::chrono::milliseconds wait) {
  return socket_.readable(std::chrono::steady_clock::now() + wait);
}

}  // namespace aprsim::crcl_server
