#include "protocols/net/tcp_listener.hpp"

#include <new>
#include <thread>

#include <gtest/gtest.h>

#include "protocols/net/run_loop.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/tcp_socket.hpp"

namespace aprsim::protocols {
namespace {

using test::TcpSocket;

TEST(TcpListener, GoesOnAcceptingAfterAThrow) {
  boost::asio::io_context io;
  int accepted = 0;
  std::vector<TcpListener::Socket> kept;
  std::vector<TcpListener::Slot> slots;
  TcpListener listener(io, "test", {},
                       [&](TcpListener::Socket socket, const std::string&, TcpListener::Slot slot) {
                         if (++accepted < 3) throw std::bad_alloc();
                         kept.push_back(std::move(socket));
                         slots.push_back(std::move(slot));
                       });
  const auto port = listener.listen();
  ASSERT_TRUE(port) << port.error().message;
  std::jthread loop([&] { run_loop(io, "test"); });
  TcpSocket first(*port), second(*port);
  EXPECT_TRUE(first.ended());
  EXPECT_TRUE(second.ended());
  const TcpSocket third(*port);
  EXPECT_TRUE(test::eventually([&] { return listener.open() == 1; }));
  boost::asio::post(io, [&] { listener.close(); });
}

}  // namespace
}  // namespace aprsim::protocols
