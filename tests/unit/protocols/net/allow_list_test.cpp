#include "protocols/net/allow_list.hpp"

#include <gtest/gtest.h>

#include "protocols/modbus/modbus_server.hpp"

namespace aprsim::protocols {
namespace {

bool allows(const AllowList& list, const char* address) {
  return list.allows(boost::asio::ip::make_address(address));
}

TEST(AllowList, AnEmptyOneAllowsEverybody) {
  const AllowList list = AllowList::from({}, "modbus.allow").value();
  for (const char* address : {"127.0.0.1", "8.8.8.8", "::1", "2001:db8::7"}) {
    EXPECT_TRUE(allows(list, address)) << address;
  }
}

TEST(AllowList, TakesNetworksAndSingleAddresses) {
  const AllowList list =
      AllowList::from({"192.168.1.0/24", "10.1.2.3", "10.9.0.7/16", "2001:db8::/32", "::1"},
                      "modbus.allow")
          .value();
  for (const char* address : {"192.168.1.0", "192.168.1.255", "10.1.2.3", "10.9.200.1",
                              "2001:db8:1::5", "::1", "::ffff:192.168.1.7"}) {
    EXPECT_TRUE(allows(list, address)) << address;
  }
  for (const char* address :
       {"192.168.2.1", "10.1.2.4", "10.8.0.7", "2001:db9::1", "::2", "::ffff:192.168.2.7"}) {
    EXPECT_FALSE(allows(list, address)) << address;
  }
}

TEST(AllowList, ZeroBitsAllowAWholeFamily) {
  const AllowList list = AllowList::from({"0.0.0.0/0"}, "modbus.allow").value();
  EXPECT_TRUE(allows(list, "203.0.113.9"));
  EXPECT_FALSE(allows(list, "2001:db8::1"));
}

TEST(AllowList, RefusesWhatIsNoNetwork) {
  for (const char* bad :
       {"", "lab", "10.0.0", "10.0.0.0/33", "10.0.0.0/", "::/129", "10.0.0.0/-1", "10.0.0.0/8 "}) {
    EXPECT_FALSE(is_network(bad)) << bad;
  }
  const auto failed = AllowList::from({"10.0.0.0/8", "lab"}, "modbus.allow");
  ASSERT_FALSE(failed.has_value());
  EXPECT_EQ(failed.error().field, "modbus.allow");
  EXPECT_NE(failed.error().message.find("'lab'"), std::string::npos);
}

}  // namespace
}  // namespace aprsim::protocols
