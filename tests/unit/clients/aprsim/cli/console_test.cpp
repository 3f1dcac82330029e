#include "clients/aprsim/cli/console.hpp"

#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/unit/clients/aprsim/cli_fixture.hpp"

namespace aprsim::client {
namespace {

struct ConsoleTest : testing::Test {
  std::ostringstream out;
  Console console{.out = out};
};

TEST_F(ConsoleTest, ControlSequencesOfOthersAreEscaped) {
  console.print(
      "robot \x1b]0;title\x07 \xc2\x9b"
      "31m \xff\n");
  EXPECT_EQ(out.str(), "robot \\x1b]0;title\\x07 \\xc2\\x9b31m \\xff\n");
}

TEST_F(ConsoleTest, JsonIsOneLineWithoutControlCharacters) {
  console.print_json({{"name", "a\x1b[2J\nb\xc2\x9b\xe2\x80\xae\xff"}});
  const std::string line = out.str();
  EXPECT_EQ(line.find('\n'), line.size() - 1);
  EXPECT_EQ(line, "{\"name\":\"a\\u001b[2J\\nb\\u009b\\u202e\xef\xbf\xbd\"}\n");
  EXPECT_TRUE(nlohmann::json::parse(line, nullptr, false).is_object());
}

/// Takes no byte, as a full disk.
struct FullBuffer : std::streambuf {
  int_type overflow(int_type) override { return traits_type::eof(); }
};

TEST(Output, ThatCannotBeWrittenIsAFailure) {
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"conveyor", "map"},
                                                    {"conveyor", "map", "--json"},
                                                    {"--help"},
                                                    {"--version"},
                                                    {"manual"},
                                                    {"completion", "bash"},
                                                    {"conform", "clauses"},
                                                    {"scenario", "list"}}) {
    FullBuffer full;
    std::ostream out(&full);
    std::ostringstream err;
    EXPECT_EQ(run(arguments, out, err), 1) << arguments.front();
    EXPECT_NE(err.str().find("cannot write the output"), std::string::npos) << err.str();
  }
}

}  // namespace
}  // namespace aprsim::client
