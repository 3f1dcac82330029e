// Effects of injected faults on the PLC's port, and its full recovery after they end.

#include "tests/support/injected_faults.hpp"

#include "tests/unit/protocols/modbus/listener_fixture.hpp"

namespace aprsim::modbus_server::testing {
namespace {

using faults::Kind;
using Clock = std::chrono::steady_clock;

class PlcFault : public ListenerTest {
 protected:
  void SetUp() override { start(); }
  test::InjectedFaultsOf faults_{cell_};
  const Bytes read_ = adu(kReadThree, 7);
  const Bytes run_ = adu(pdu(6, {0x8000, 1}), 8);
};

TEST_F(PlcFault, ExceptionsAnswerEverythingAndNothingIsDone) {
  RawClient client(port_);
  const auto usual = client.ask(read_);
  ASSERT_TRUE(usual);
  faults_.begin(Kind::kModbusExceptions, -1, {6});
  for (const Bytes& request : {read_, run_}) {
    const auto reply = client.ask(request);
    ASSERT_TRUE(reply);
    ASSERT_EQ(reply->size(), 9U);
    EXPECT_EQ((*reply)[7], request[7] | 0x80);
    EXPECT_EQ((*reply)[8], 6);
  }
  EXPECT_TRUE(cell_.commands().empty());
  faults_.end();
  EXPECT_EQ(client.ask(read_), usual);
}

TEST_F(PlcFault, LateRepliesComeLateAndInOrder) {
  RawClient client(port_);
  faults_.begin(Kind::kModbusDelay, -1, {0.3});
  const auto asked = Clock::now();
  ASSERT_TRUE(client.send(adu(kReadThree, 1)));
  ASSERT_TRUE(client.send(adu(kReadThree, 2)));
  const auto first = client.receive();
  EXPECT_GE(Clock::now() - asked, 300ms);
  const auto second = client.receive();
  ASSERT_TRUE(first && second);
  EXPECT_EQ((*first)[1], 1);
  EXPECT_EQ((*second)[1], 2);
  faults_.end();
  EXPECT_TRUE(client.ask(read_));
}

TEST_F(PlcFault, ASilentOneCarriesOutAndSaysNothing) {
  RawClient client(port_);
  faults_.begin(Kind::kModbusSilent);
  ASSERT_TRUE(client.send(run_));
  EXPECT_TRUE(cell_.wait_for_commands(1));
  EXPECT_TRUE(eventually([&] { return cell_.latest()->conveyor.run; }));
  EXPECT_FALSE(client.receive(200ms));
  faults_.end();
  const auto reply = client.ask(read_);
  ASSERT_TRUE(reply);
  EXPECT_EQ((*reply)[1], 7) << "of this request";
}

TEST_F(PlcFault, AStrayReplyComesFirst) {
  RawClient client(port_);
  const auto usual = client.ask(read_);
  ASSERT_TRUE(usual);
  faults_.begin(Kind::kModbusStray);
  const auto stray = client.ask(read_);
  ASSERT_TRUE(stray);
  EXPECT_NE((*stray)[0], (*usual)[0]) << "under another transaction number";
  EXPECT_EQ(Bytes(stray->begin() + 2, stray->end()), Bytes(usual->begin() + 2, usual->end()));
  EXPECT_EQ(client.receive(), usual);
  faults_.end();
  EXPECT_EQ(client.ask(read_), usual);
}

TEST_F(PlcFault, ARefusingPortDropsItsClientsAndComesBack) {
  RawClient client(port_);
  ASSERT_TRUE(client.ask(read_));
  faults_.begin(Kind::kModbusRefused);
  EXPECT_FALSE(client.receive(5s)) << "closed";
  EXPECT_TRUE(eventually([&] {
    try {
      RawClient refused(port_);
      return false;
    } catch (const std::exception&) {
      return true;
    }
  }));
  faults_.end();
  EXPECT_TRUE(eventually([&] {
    try {
      RawClient again(port_);
      return again.ask(read_).has_value();
    } catch (const std::exception&) {
      return false;
    }
  }));
}

}  // namespace
}  // namespace aprsim::modbus_server::testing
