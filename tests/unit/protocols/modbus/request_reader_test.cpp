#include "protocols/modbus/request_reader.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/modbus/bytes.hpp"

namespace aprsim::modbus_server {
namespace {

using modbus::Verdict;
using modbus::testing::adu;
using modbus::testing::Bytes;
using modbus::testing::pdu;

class RequestReaderTest : public ::testing::Test {
 protected:
  template <typename Range>
  void receive(const Range& bytes) {
    const auto room = reader_.room();
    ASSERT_GE(room.size(), bytes.size());
    std::copy(bytes.begin(), bytes.end(), room.begin());
    reader_.append(bytes.size());
  }

  modbus::RequestRules rules_;
  RequestReader reader_{rules_};
  const Bytes request_ = adu(pdu(3, {0x8000, 1}));
};

TEST_F(RequestReaderTest, CutsAStreamIntoRequests) {
  Bytes two = request_;
  two.insert(two.end(), request_.begin(), request_.end());
  two.resize(two.size() - 3);
  receive(two);
  EXPECT_EQ(reader_.next().verdict, Verdict::kRequest);
  EXPECT_EQ(reader_.next().verdict, Verdict::kIncomplete);
  EXPECT_TRUE(reader_.incomplete());
  EXPECT_EQ(reader_.rest().size(), request_.size() - 3);
  reader_.compact();
  receive(Bytes(request_.end() - 3, request_.end()));
  EXPECT_EQ(reader_.next().verdict, Verdict::kRequest);
  EXPECT_FALSE(reader_.incomplete());
  EXPECT_TRUE(reader_.rest().empty());
}

TEST_F(RequestReaderTest, UsedBytesGiveTheirSpaceBack) {
  const std::size_t space = reader_.room().size();
  receive(request_);
  ASSERT_EQ(reader_.next().verdict, Verdict::kRequest);
  EXPECT_EQ(reader_.room().size(), space - request_.size());
  reader_.compact();
  EXPECT_EQ(reader_.room().size(), space);
}

TEST_F(RequestReaderTest, BrokenStreamStaysWhereItIs) {
  Bytes broken = request_;
  broken[4] = 0xFF;  // a length that no message has
  receive(broken);
  EXPECT_EQ(reader_.next().verdict, Verdict::kBroken);
  EXPECT_EQ(reader_.rest().size(), broken.size());
}

TEST_F(RequestReaderTest, NamesAnotherProtocolOnceItCanBeTold) {
  receive(std::string_view("GET"));
  EXPECT_TRUE(reader_.foreign_protocol().empty());
  receive(std::string_view(" / HTTP/1.1\r\n"));
  EXPECT_EQ(reader_.foreign_protocol(), "HTTP");
}

TEST_F(RequestReaderTest, ModbusIsNoForeignProtocol) {
  receive(request_);
  EXPECT_TRUE(reader_.foreign_protocol().empty());
}

}  // namespace
}  // namespace aprsim::modbus_server
