#include "protocols/grpc/calls/call_peer.hpp"

#include <gtest/gtest.h>

namespace aprsim::grpc_server {
namespace {

TEST(CallPeer, IsReadFromTheNameOfItsRelay) {
  const CallPeer peer = call_peer("unix-abstract:127.0.0.1%3A43210/77.12.345");
  EXPECT_EQ(peer.address, "127.0.0.1:43210");
  EXPECT_EQ(peer.connection, 345U);
  EXPECT_EQ(call_peer("unix-abstract:[%3A%3A1]%3A5/1.2.0").address, "[::1]:5");
}

TEST(CallPeer, KeepsUnknownSchemes) {
  EXPECT_EQ(call_peer("ipv4:10.0.0.1:80").address, "10.0.0.1:80");
  EXPECT_EQ(call_peer("ipv4:10.0.0.1:80").connection, 0U);
  EXPECT_EQ(call_peer("").address, "");
  EXPECT_EQ(call_peer("unix:%").address, "%");
}

}  // namespace
}  // namespace aprsim::grpc_server
