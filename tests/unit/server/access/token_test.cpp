#include "server/access/token.hpp"

#include <string>

#include <gtest/gtest.h>

#include "tests/support/temporary_directory.hpp"

namespace aprsim::server {
namespace {

class Token : public testing::Test {
 protected:
  void file(const std::string& text) {
    directory_.write("token", text);
    web.token_file = directory_.path() + "/token";
  }
  /// The fault; "" = none.
  std::string fault(const char* environment = nullptr) {
    const auto ok = resolve_token(web, environment);
    return ok ? "" : ok.error().message;
  }

 private:
  test::TemporaryDirectory directory_;

 protected:
  WebConfig web;
};

TEST_F(Token, IsTheFilesFirstLine) {
  for (const char* text : {"open sesame", "open sesame\n", "open sesame\r\nmore\n"}) {
    web = {};
    file(text);
    EXPECT_EQ(fault("of the environment"), "");
    EXPECT_EQ(web.token, "open sesame");
  }
}

TEST_F(Token, ComesFromTheEnvironmentWhenTheConfigurationHasNone) {
  EXPECT_EQ(fault(), "");
  EXPECT_EQ(fault(""), "");
  EXPECT_EQ(web.token, "");
  EXPECT_EQ(fault("open sesame"), "");
  EXPECT_EQ(web.token, "open sesame");
  web.token = "of the configuration";
  EXPECT_EQ(fault("open sesame"), "");
  EXPECT_EQ(web.token, "of the configuration");
}

TEST_F(Token, SaysWhatIsWrongWithoutShowingIt) {
  web.token_file = "/nonexistent/token";
  EXPECT_EQ(fault(), "web.token_file: cannot read /nonexistent/token: No such file or directory");
  web = {};
  for (const std::string& text :
       {std::string("secret"), std::string(" secretive "), std::string("secret\x01\x02\x03"),
        "secret" + std::string(300, 'x'), std::string("\nsecretive")}) {
    web = {};
    file(text);
    const std::string message = fault();
    EXPECT_NE(message.find("web.token_file: first line of"), std::string::npos) << message;
    EXPECT_NE(message.find("at least 8 characters"), std::string::npos) << message;
    EXPECT_EQ(message.find("secret"), std::string::npos) << message;
  }
  web = {};
  EXPECT_EQ(fault("secret").find("APRSIM_TOKEN: expected at least 8"), 0U);
  file("open sesame");
  web.token = "of the configuration";
  EXPECT_EQ(fault(), "web.token_file: web.token is set, too");
}

}  // namespace
}  // namespace aprsim::server
