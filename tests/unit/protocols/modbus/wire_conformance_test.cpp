// Every function at every limit over a plain socket, as a client sees it.

#include <gtest/gtest.h>

#include "modbus/conformance_cases.hpp"
#include "protocols/modbus/modbus_server.hpp"
#include "tests/support/fake_cell.hpp"
#include "tests/support/parameter_names.hpp"
#include "tests/unit/modbus/bytes.hpp"
#include "tests/unit/protocols/modbus/raw_client.hpp"

namespace aprsim::modbus_server {
namespace {

using modbus::testing::adu;
using modbus::testing::conformance_cases;
using modbus::testing::ConformanceCase;
using modbus::testing::kAccepted;
using test::FakeCell;
using testing::Bytes;
using testing::RawClient;

/// Size of the reply's PDU to an accepted request, and what of the request it repeats.
struct Form {
  std::size_t size = 0, echoed = 1;
};

Form form_of(const Bytes& pdu) {
  const auto quantity = static_cast<std::size_t>(pdu[3] << 8 | pdu[4]);
  switch (pdu[0]) {
    case 1:
    case 2:
      return {2 + (quantity + 7) / 8, 1};
    case 3:
    case 4:
    case 23:
      return {2 + 2 * quantity, 1};
    case 22:
      return {7, 7};
    default:
      return {5, 5};
  }
}

class WireConformance : public ::testing::TestWithParam<ConformanceCase> {
 protected:
  WireConformance() { port_ = server_.start().value(); }
  ~WireConformance() override { server_.stop(); }

  FakeCell cell_{FakeCell::Commands::kApplied};
  ModbusServer server_{{.listener = {}}, cell_, cell_};
  std::uint16_t port_ = 0;
};

TEST_P(WireConformance, IsAnsweredAsTheSpecificationSays) {
  const Bytes& pdu = GetParam().pdu;
  RawClient client(port_);
  const auto reply = client.ask(adu(pdu, 0xBEEF, 255));
  ASSERT_TRUE(reply.has_value());
  if (GetParam().exception != kAccepted) {
    const auto code = static_cast<std::uint8_t>(GetParam().exception);
    EXPECT_EQ(*reply, adu({static_cast<std::uint8_t>(pdu[0] | 0x80), code}, 0xBEEF, 255));
    EXPECT_TRUE(cell_.commands().empty()) << "refused, and yet it took effect";
  } else {
    const Form form = form_of(pdu);
    Bytes expected(reply->begin() + 7, reply->end());
    ASSERT_EQ(expected.size(), form.size);
    std::copy_n(pdu.begin(), form.echoed, expected.begin());
    if (form.echoed == 1) expected[1] = static_cast<std::uint8_t>(form.size - 2);
    EXPECT_EQ(*reply, adu(expected, 0xBEEF, 255));
  }
  const Bytes next = adu({3, 0x80, 0xF0, 0, 1}, 2, 1);
  EXPECT_TRUE(client.ask(next).has_value()) << "and the stream goes on";
}

INSTANTIATE_TEST_SUITE_P(Socket, WireConformance, ::testing::ValuesIn(conformance_cases()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace aprsim::modbus_server
