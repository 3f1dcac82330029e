#include "server/access/access_file.hpp"

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "server/access/token_command.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::server {
namespace {

using protocols::Role;

class AccessFiles : public testing::Test {
 protected:
  /// The fault of a file of this text; "" = none.
  std::string fault(const std::string& text, mode_t mode = 0600) {
    directory.write("access", text);
    chmod(path.c_str(), mode);
    const auto file = read_access_file(path);
    return file ? "" : file.error().message;
  }

  int command(const std::vector<std::string>& arguments) {
    out.str("");
    err.str("");
    return token_command(arguments, out, err);
  }

  /// The entry that a token has in the file; null = none.
  std::optional<protocols::TokenEntry> entry(const std::string& token) const {
    const auto file = read_access_file(path);
    for (const auto& entry : file.value().tokens) {
      if (protocols::digest_of(entry.salt, token) == entry.digest) return entry;
    }
    return std::nullopt;
  }

  std::string text() const {
    std::ifstream in(path);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/access";
  std::ostringstream out, err;
};

TEST_F(AccessFiles, TokensAreMadeListedAndRemoved) {
  ASSERT_EQ(command({"add", "--file", path, "--role", "operate", "alice"}), 0) << err.str();
  const std::string token = out.str().substr(0, out.str().find('\n'));
  EXPECT_EQ(out.str(), token + "\n") << "the token alone";
  EXPECT_GE(token.size(), 64U);
  EXPECT_EQ(text().find(token), std::string::npos) << "it is kept as a hash";
  ASSERT_EQ(command({"add", "bob", "--role", "admin", "--expires", "30d", "--file", path}), 0);
  const std::string other = out.str().substr(0, out.str().find('\n'));
  EXPECT_NE(token, other);
  struct stat status {};
  ASSERT_EQ(stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);

  ASSERT_TRUE(entry(token));
  EXPECT_EQ(entry(token)->name, "alice");
  EXPECT_EQ(entry(token)->role, Role::kOperate);
  EXPECT_FALSE(entry(token)->expires);
  ASSERT_TRUE(entry(other)->expires);
  const auto left = *entry(other)->expires - std::chrono::system_clock::now();
  EXPECT_GT(left, std::chrono::hours(24 * 30 - 1));
  EXPECT_LT(left, std::chrono::hours(24 * 30 + 1));
  EXPECT_NE(entry(token)->salt, entry(other)->salt);

  ASSERT_EQ(command({"add", "--certificate", "operator.lab", "--role", "view", "--file", path}), 0);
  ASSERT_EQ(command({"list", "--file", path}), 0);
  for (const char* part : {"alice", "operate", "never expires", "bob", "until ", "operator.lab"}) {
    EXPECT_NE(out.str().find(part), std::string::npos) << part << '\n' << out.str();
  }
  ASSERT_EQ(command({"remove", "alice", "--file", path}), 0);
  EXPECT_FALSE(entry(token));
  EXPECT_TRUE(entry(other));
  ASSERT_EQ(command({"remove", "operator.lab", "--certificate", "--file", path}), 0);
  EXPECT_TRUE(read_access_file(path)->certificates.empty());
}

TEST_F(AccessFiles, ReportsFaultyFiles) {
  ASSERT_EQ(command({"add", "alice", "--role", "view", "--file", path}), 0);
  const std::string before = text();
  const std::vector<std::tuple<std::vector<std::string>, int, std::string>> wrong{
      {{"add", "alice", "--role", "view"}, 1, "alice is in"},
      {{"add", "bob", "--role", "king"}, 2, "king"},
      {{"add", "bob"}, 2, "--role"},
      {{"add", "b b", "--role", "view"}, 2, "'b b' is not 1 to 64"},
      {{"add", "bob", "--role", "view", "--expires", "soon"}, 2, "'soon' is neither"},
      {{"add", "bob", "--role", "view", "--expires", "2020-01-01"}, 2, "2020-01-01 is over"},
      {{"add", "bob", "--role", "view", "--expires", "2099-02-31"}, 2, "neither a time"},
      {{"remove", "bob"}, 1, "bob is not in"},
      {{}, 2, "a command is missing"}};
  for (auto [arguments, code, message] : wrong) {
    if (!arguments.empty()) arguments.insert(arguments.end(), {"--file", path});
    EXPECT_EQ(command(arguments), code) << message;
    EXPECT_NE(err.str().find(message), std::string::npos) << err.str();
  }
  EXPECT_EQ(command({"list", "--file", "/nonexistent/access"}), 1);
  EXPECT_NE(err.str().find("cannot read /nonexistent/access: No such file"), std::string::npos);
  EXPECT_EQ(command({"add", "a", "--role", "view", "--file", "/nonexistent/access"}), 1);
  EXPECT_EQ(text(), before);
}

TEST_F(AccessFiles, AreRefusedWhereOthersReachThem) {
  for (const mode_t mode : std::initializer_list<mode_t>{0640, 0604, 0620, 0666}) {
    const std::string message = fault("tokens: []\n", mode);
    EXPECT_EQ(message.find("access.file: " + path + " has mode 6"), 0U) << message;
    EXPECT_NE(message.find("expected 600"), std::string::npos) << message;
  }
  EXPECT_EQ(fault("tokens: []\n", 0400), "");
  EXPECT_NE(read_access_file(directory.path()).error().message.find("expected a regular file"),
            std::string::npos);
}

TEST_F(AccessFiles, MistakesAreNamedWithTheirPlace) {
  const std::string salt(32, '0'), digest(64, 'a');
  const auto token = [&](const std::string& rest) {
    return "tokens:\n  - {name: a, role: view, salt: \"" + salt + "\", sha256: \"" + digest + "\"" +
           rest + "}\n";
  };
  EXPECT_EQ(fault(token("")), "");
  EXPECT_EQ(fault(token(", expires: 2030-01-01")), "");
  for (const auto& [text, part] : std::vector<std::pair<std::string, std::string>>{
           {"tokens: [{name: a}]\n", "access:1:"},
           {token(", expires: never"), "expires: found"},
           {token(", until: 1"), "until"},
           {token("") + "certificates: [{name: b, role: none}]\n", "certificates[0].role"},
           {token("") + "  - {name: a, role: view, salt: \"" + salt + "\", sha256: \"" + digest +
                "\"}\n",
            "a again"},
           {"tokens: [{name: a, role: view, salt: \"00\", sha256: \"" + digest + "\"}]\n",
            "32 hexadecimal"},
           {"tokens: [{name: a, role: view, salt: \"" + salt + "\", sha256: \"secret\"}]\n",
            "64 hexadecimal"}}) {
    const std::string message = fault(text);
    EXPECT_EQ(message.find("access.file: "), 0U) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_EQ(message.find("secret"), std::string::npos) << message;
  }
}

TEST_F(AccessFiles, NamesOfCertificatesComeBackAsTheyWere) {
  AccessFile file;
  for (const char* name : {"a \"b\"", "back\\slash", "*.lab.example", "O=x,CN=y: z #"}) {
    file.certificates.push_back({name, Role::kInject});
  }
  ASSERT_TRUE(write_access_file(path, file));
  const auto read = read_access_file(path);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->certificates.size(), file.certificates.size());
  for (std::size_t i = 0; i < file.certificates.size(); ++i) {
    EXPECT_EQ(read->certificates[i].name, file.certificates[i].name);
  }
}

}  // namespace
}  // namespace aprsim::server
