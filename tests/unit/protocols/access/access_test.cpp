#include "protocols/access/access.hpp"

#include <string>

#include <gtest/gtest.h>

#include "tests/support/access_with.hpp"

namespace aprsim::protocols {
namespace {

using namespace std::chrono_literals;
using Kind = Refusal::Kind;
using Problem = Caller::Problem;

constexpr WallTime kNow{std::chrono::hours(24 * 365 * 60)};
const std::string kFar = "10.0.0.1";

/// Identification of callers by the tokens of rules_with_tokens().
class AccessOfTokens : public testing::Test {
 protected:
  Caller call(const std::string& token, const std::string& host = kFar) {
    return access.identify(host, {.token = token}, kNow, clock);
  }

  Access access{test::rules_with_tokens()};
  Access::Clock::time_point clock{};
};

TEST_F(AccessOfTokens, TakesATokenOnlyWhole) {
  for (const char* guess : {"", "right", "right-tokem", "right-tokenright-token", "Right-token"}) {
    EXPECT_EQ(call(guess).problem, Problem::kWrongToken) << guess;
    clock += 1h;
  }
  const Caller caller = call("right-token");
  EXPECT_EQ(caller.problem, Problem::kNone);
  EXPECT_EQ(caller.name, "token right");
  EXPECT_EQ(caller.role, Role::kAdmin);
}

TEST_F(AccessOfTokens, EachRoleMayWhatThoseBeforeItMay) {
  for (const Role has : {Role::kView, Role::kOperate, Role::kInject, Role::kAdmin}) {
    const Caller caller = call(std::string(to_text(has)) + "-token");
    for (const Role needed :
         {Role::kNone, Role::kView, Role::kOperate, Role::kInject, Role::kAdmin}) {
      const auto refusal = access.refusal(caller, "it", needed);
      EXPECT_EQ(refusal.has_value(), has < needed);
      if (!refusal) continue;
      EXPECT_EQ(refusal->kind, Kind::kPermission);
      EXPECT_EQ(refusal->message,
                "authorization: it needs the role " + std::string(to_text(needed)) + "; token " +
                    std::string(to_text(has)) + " has " + std::string(to_text(has)));
    }
  }
  EXPECT_EQ(access.counts().permission, 6U);
}

TEST_F(AccessOfTokens, WithoutOneOrWithAWrongOneSaysWhatIsMissing) {
  const auto none = access.refusal(access.identify(kFar, {}, kNow, clock), "it", Role::kOperate);
  ASSERT_TRUE(none);
  EXPECT_EQ(none->kind, Kind::kUnauthenticated);
  EXPECT_NE(none->message.find("needs the role operate, by a token"), std::string::npos);
  EXPECT_FALSE(access.refusal(access.identify(kFar, {}, kNow, clock), "it", Role::kView));
  // A caller with a wrong token is not treated as anonymous.
  const auto wrong = access.refusal(call("guess"), "it", Role::kView);
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->kind, Kind::kUnauthenticated);
  EXPECT_EQ(wrong->message.find("guess"), std::string::npos);
  EXPECT_FALSE(access.refusal(call("guess"), "it", Role::kNone));
  EXPECT_EQ(access.counts().unauthenticated, 2U);
}

TEST_F(AccessOfTokens, ExpireAndAreRemovedAlsoUnderAConnection) {
  AccessRules rules = test::rules_with_tokens();
  for (auto& token : rules.tokens) token.expires = kNow + 1h;
  access.replace(rules);
  const Caller caller = call("inject-token");
  EXPECT_EQ(caller.role, Role::kInject);
  EXPECT_EQ(access.still(caller, kNow), Role::kInject);
  EXPECT_EQ(access.still(caller, kNow + 1h), Role::kView) << "as without it";
  const Caller late = access.identify(kFar, {.token = "inject-token"}, kNow + 1h, clock);
  EXPECT_EQ(late.problem, Problem::kExpired);
  const auto refusal = access.refusal(late, "it", Role::kView);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->message.find("authorization: token inject has expired"), 0U);
  std::erase_if(rules.tokens, [](const TokenEntry& token) { return token.name == "inject"; });
  access.replace(rules);
  EXPECT_EQ(access.still(caller, kNow), Role::kView);
}

TEST_F(AccessOfTokens, LimitWrongOnesOfAnAddress) {
  for (int i = 0; i < 5; ++i) EXPECT_EQ(call("guess").problem, Problem::kWrongToken);
  EXPECT_EQ(call("guess").problem, Problem::kTooManyAttempts);
  EXPECT_EQ(access.refusal(call("guess"), "it", Role::kView)->kind, Kind::kTooManyAttempts);
  EXPECT_EQ(call("guess", "10.0.0.2").problem, Problem::kWrongToken) << "another address";
  clock += 6s;
  EXPECT_EQ(call("guess").problem, Problem::kWrongToken);
}

/// Behind one address there may be many programs.
TEST_F(AccessOfTokens, LimitEachWrongOneByItself) {
  for (int i = 0; i < 100; ++i) (void)call("stale");
  EXPECT_EQ(call("stale").problem, Problem::kTooManyAttempts);
  EXPECT_EQ(call("typing error").problem, Problem::kWrongToken);
  EXPECT_EQ(call("right-token").problem, Problem::kNone);
}

TEST_F(AccessOfTokens, LimitTheNumberOfDifferentOnes) {
  int tried = 0;
  for (int i = 0; i < 1000; ++i) {
    if (call("guess-" + std::to_string(i)).problem == Problem::kWrongToken) ++tried;
  }
  EXPECT_EQ(tried, 5);
  clock += 6s;
  EXPECT_EQ(call("another").problem, Problem::kWrongToken);
}

TEST_F(AccessOfTokens, NeverLimitARightOne) {
  for (int i = 0; i < 1000; ++i) {
    (void)call("guess-" + std::to_string(i));
    ASSERT_EQ(call("right-token").problem, Problem::kNone) << i;
  }
  EXPECT_EQ(access.refusal(call("right-token"), "it", Role::kView), std::nullopt);
}

TEST_F(AccessOfTokens, CountNothingWhenTheyAreRight) {
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(call("right-token").problem, Problem::kNone) << i;
}

TEST_F(AccessOfTokens, TakeAMachinesIPv6NetworkForOneAddress) {
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(call("guess", "2001:db8::" + std::to_string(i)).problem, Problem::kWrongToken);
  }
  EXPECT_EQ(call("guess", "2001:db8::99").problem, Problem::kTooManyAttempts);
}

TEST_F(AccessOfTokens, HoldAlsoAgainstManyAddresses) {
  int tried = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::string host = "10." + std::to_string(i / 65536) + "." +
                             std::to_string(i / 256 % 256) + "." + std::to_string(i % 256);
    if (call("guess", host).problem == Problem::kWrongToken) ++tried;
  }
  EXPECT_LT(tried, 5000) << "those beyond what is remembered share one limit";
  clock += 1h;
  EXPECT_EQ(call("right-token", "192.168.0.1").problem, Problem::kNone);
}

TEST(Access, WithoutCredentialsThisMachineMayAllOthersLook) {
  Access access{AccessRules{}};
  for (const char* host : {"127.0.0.1", "127.3.2.1", "::1", "::ffff:127.0.0.1"}) {
    EXPECT_EQ(access.identify(host, {}).role, Role::kAdmin) << host;
  }
  for (const char* host : {"10.0.0.1", "::ffff:10.0.0.1", "2001:db8::1"}) {
    const Caller caller = access.identify(host, {});
    EXPECT_EQ(caller.role, Role::kView) << host;
    const auto refusal = access.refusal(caller, "it", Role::kOperate);
    ASSERT_TRUE(refusal);
    EXPECT_EQ(refusal->kind, Kind::kPermission);
    EXPECT_NE(refusal->message.find("--insecure-control"), std::string::npos);
  }
}

TEST(Access, ACertificatesNamesHaveRoles) {
  Access access{
      AccessRules{.certificates = {{"operator.lab", Role::kOperate}, {"lab", Role::kView}},
                  .local = Role::kNone,
                  .others = Role::kNone}};
  const auto with = [&](std::vector<std::string> names) {
    return access.identify(kFar, {.certificate = std::make_shared<ClientCertificate>(
                                      ClientCertificate{"CN=whoever", std::move(names)})});
  };
  EXPECT_EQ(with({"lab", "operator.lab"}).role, Role::kOperate);
  EXPECT_EQ(with({"lab"}).role, Role::kView);
  EXPECT_EQ(with({"operator.lab.example", "LAB", ""}).role, Role::kNone);
  EXPECT_EQ(with({"lab"}).name, "certificate CN=whoever");
  const Caller caller = with({"operator.lab"});
  access.replace({.local = Role::kNone, .others = Role::kNone});
  EXPECT_EQ(access.still(caller), Role::kNone);
}

}  // namespace
}  // namespace aprsim::protocols
