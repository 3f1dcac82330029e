#include "protocols/modbus/security/handshake_pace.hpp"

#include <vector>

#include <boost/asio/io_context.hpp>
#include <gtest/gtest.h>

namespace aprsim::modbus_server {
namespace {

TEST(HandshakePace, StartsAllInTheirOrder) {
  boost::asio::io_context io;
  HandshakePace pace(io.get_executor());
  std::vector<int> started, expected;
  std::vector<int> connections(50);
  for (int i = 0; i < 50; ++i) {
    pace.admit(&connections[static_cast<std::size_t>(i)], [&started, i] { started.push_back(i); });
    expected.push_back(i);
  }
  EXPECT_GE(started.size(), static_cast<std::size_t>(HandshakePace::kBurst));
  EXPECT_LT(started.size(), 50U) << "a flood waits";
  io.run();
  EXPECT_EQ(started, expected);
}

TEST(HandshakePace, ForgetsConnectionsThatLeave) {
  boost::asio::io_context io;
  HandshakePace pace(io.get_executor());
  std::vector<int> connections(1000);
  int started = 0;
  for (int& connection : connections) pace.admit(&connection, [&started] { ++started; });
  const int before = started;
  for (int& connection : connections) pace.leave(&connection);
  io.run();
  EXPECT_EQ(started, before);
  pace.admit(connections.data(), [&started] { ++started; });
  io.restart();
  io.run();
  EXPECT_EQ(started, before + 1) << "the next one has its turn";
}

}  // namespace
}  // namespace aprsim::modbus_server
