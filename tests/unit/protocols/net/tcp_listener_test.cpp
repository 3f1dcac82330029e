#include "protocols/net/tcp_listener.hpp"

#include <algorithm>
#include <new>
#include <string>
#include <thread>
#include <vector>

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

TEST(TcpListener, LocalhostIsBothLoopbacksAtOnePort) {
  using boost::asio::ip::tcp;
  boost::asio::io_context io;
  std::vector<std::string> peers;
  TcpListener listener(io, "test", {.address = "localhost"},
                       [&](TcpListener::Socket, const std::string& peer, TcpListener::Slot) {
                         peers.push_back(peer);
                       });
  const auto port = listener.listen();
  ASSERT_TRUE(port) << port.error().message;
  boost::asio::io_context outside;
  tcp::socket four(outside), six(outside);
  boost::system::error_code error;
  four.connect({boost::asio::ip::address_v4::loopback(), *port}, error);
  EXPECT_FALSE(error) << error.message();
  tcp::acceptor probe(outside);
  probe.open(tcp::v6(), error);
  if (!error) probe.bind({boost::asio::ip::address_v6::loopback(), 0}, error);
  const bool has_ipv6 = !error;
  if (has_ipv6) {
    six.connect({boost::asio::ip::address_v6::loopback(), *port}, error);
    EXPECT_FALSE(error) << error.message();
  }
  std::jthread loop([&] { run_loop(io, "test"); });
  EXPECT_TRUE(test::eventually([&] { return listener.accepted() == (has_ipv6 ? 2U : 1U); }));
  boost::asio::post(io, [&] { listener.close(); });
  loop.join();
  EXPECT_EQ(std::ranges::count_if(
                peers, [](const std::string& peer) { return peer.starts_with("[::1]:"); }),
            has_ipv6 ? 1 : 0);
}

}  // namespace
}  // namespace aprsim::protocols
