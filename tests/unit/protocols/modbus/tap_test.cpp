// Records that the listener sends to a wire tap.

#include "tests/unit/protocols/modbus/listener_fixture.hpp"

namespace aprsim::modbus_server::testing {
namespace {

class ModbusTap : public ListenerTest {
 protected:
  ~ModbusTap() override {
    if (server_) server_->stop();
  }
  void start_tapped() {
    ModbusServerOptions options;
    options.tap = &tap_;
    start(options);
  }
  [[nodiscard]] std::vector<protocols::WireEventPtr> seen() const {
    std::vector<protocols::WireEventPtr> events;
    (void)tap_.read(1, true, ~std::size_t{0}, events);
    return events;
  }

  protocols::WireTap tap_{cell_};
};

TEST_F(ModbusTap, WritesAndTheirRepliesAreKeptThoughNobodyLooks) {
  start_tapped();
  RawClient client(port_);
  ASSERT_TRUE(client.ask(adu(kReadThree, 1)));
  ASSERT_TRUE(client.ask(adu(pdu(6, {0x8002, 15000}), 2)));
  ASSERT_TRUE(client.ask(adu(pdu(6, {0x8002, 40000}), 3)));
  const auto events = seen();
  ASSERT_EQ(events.size(), 4u);
  EXPECT_EQ(events[0]->id, 2);
  EXPECT_TRUE(events[0]->from_client);
  EXPECT_FALSE(events[1]->from_client);
  EXPECT_EQ(events[3]->id, 3);
  EXPECT_EQ(events[3]->data.substr(7), "\x86\x03") << "illegal data value";
}

TEST_F(ModbusTap, ReadsShowWhileSomebodyWatches) {
  start_tapped();
  RawClient client(port_);
  tap_.want_polls(true);
  ASSERT_TRUE(client.ask(adu(kReadThree, 1)));
  const auto events = seen();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_TRUE(events[0]->poll && events[1]->poll);
}

}  // namespace
}  // namespace aprsim::modbus_server::testing
