// Records that the listener sends to a wire tap.

#include "tests/unit/protocols/crcl/server_fixture.hpp"

namespace aprsim::crcl_server {
namespace {

class Tap : public ServerTest {
 protected:
  void SetUp() override {
    CrclServerOptions options;
    options.tap = &tap_;
    start(options);
  }
  ~Tap() override { server_.reset(); }

  [[nodiscard]] std::vector<std::string> seen() const {
    std::vector<protocols::WireEventPtr> events;
    (void)tap_.read(1, true, ~std::size_t{0}, events);
    std::vector<std::string> lines;
    for (const auto& event : events) {
      lines.push_back(std::string(event->from_client ? "> " : "< ") + (event->poll ? "poll " : "") +
                      event->type + " " + std::to_string(event->id) +
                      (event->state.empty() ? "" : " " + event->state));
    }
    return lines;
  }

  protocols::WireTap tap_{world_};
};

using Lines = std::vector<std::string>;

TEST_F(Tap, CommandsAndTheirEndsAreKeptThoughNobodyLooks) {
  TestClient client(port_), other(port_);
  initialize(client);
  for (int i = 0; i < 20; ++i) (void)client.status();
  (void)other.status();
  client.command(5, "MoveToType", move());
  const api::Ticket moving = ticket(2);
  world_.report(0, moving, ActionState::kWorking);
  (void)client.status();
  world_.report(0, moving, ActionState::kError, "out of reach");
  (void)client.status();
  (void)other.status();
  EXPECT_EQ(seen(), (Lines{"> InitCanonType 4", "< CRCLStatusType 4 CRCL_Done", "> MoveToType 5",
                           "< CRCLStatusType 5 CRCL_Error: out of reach"}));
}

TEST_F(Tap, TheSameIdAgainIsAnotherCommand) {
  TestClient client(port_);
  initialize(client);
  client.command(4, "InitCanonType");
  world_.report(0, ticket(2), ActionState::kDone);
  (void)client.status();
  const Lines once{"> InitCanonType 4", "< CRCLStatusType 4 CRCL_Done"};
  EXPECT_EQ(seen(), (Lines{once[0], once[1], once[0], once[1]}));
}

TEST_F(Tap, PollsShowWhileSomebodyWatches) {
  TestClient client(port_);
  (void)client.status();
  tap_.want_polls(true);
  (void)client.status();
  (void)client.status();
  EXPECT_EQ(seen(), (Lines{"> poll GetStatusType 999", "< poll CRCLStatusType -1 CRCL_Ready",
                           "> poll GetStatusType 999", "< poll CRCLStatusType -1 CRCL_Ready"}));
}

TEST_F(Tap, BadDocumentsAreKeptWithTheirReason) {
  TestClient client(port_);
  initialize(client);
  client.command(6, "FlyType");
  client.expect_closed();
  const Lines lines = seen();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_TRUE(lines[2].starts_with("> FlyType 6 ")) << lines[2];
}

}  // namespace
}  // namespace aprsim::crcl_server
