#include "protocols/modbus/security/client_rights.hpp"

#include <gtest/gtest.h>

#include "modbus/request.hpp"

namespace aprsim::modbus_server {
namespace {

using protocols::Role;

TEST(ClientRights, AreEverythingWithoutTls) {
  const ClientRights rights;
  for (int function = 0; function < 256; ++function) {
    EXPECT_FALSE(rights.refusal(static_cast<std::uint8_t>(function))) << function;
  }
}

TEST(ClientRights, ViewReadsAndOperateWritesByEveryFunction) {
  const ClientRights none("", Role::kNone), view("", Role::kView), operate("", Role::kOperate);
  for (int i = 0; i < 256; ++i) {
    const auto function = static_cast<std::uint8_t>(i);
    EXPECT_TRUE(none.refusal(function)) << i;
    EXPECT_FALSE(operate.refusal(function)) << i;
    EXPECT_EQ(view.refusal(function).has_value(), modbus::is_writing_function(function)) << i;
  }
  for (const int writes : {5, 6, 15, 16, 22, 23}) {
    EXPECT_TRUE(view.refusal(static_cast<std::uint8_t>(writes)));
  }
  for (const int reads : {1, 2, 3, 4, 43}) {
    EXPECT_FALSE(view.refusal(static_cast<std::uint8_t>(reads)));
  }
  EXPECT_EQ(view.refusal(6), "function 6 needs the right operate; it has view");
  EXPECT_EQ(none.refusal(3), "function 3 needs the right view; it has none");
}

}  // namespace
}  // namespace aprsim::modbus_server
