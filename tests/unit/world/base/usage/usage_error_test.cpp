#include "world/base/usage/usage_error.hpp"

#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>

namespace aprsim::usage {
namespace {

std::string error_of(CLI::App& app, const std::string& arguments) {
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    return usage_error(app, error);
  }
  return "no error";
}

TEST(UsageError, SuggestsTheNearestOption) {
  std::string scene;
  bool any_port = false;
  CLI::App app("A program", "aprsimd");
  app.add_option("--scene", scene);
  app.add_flag("--any-port", any_port);
  EXPECT_EQ(error_of(app, "--scnee aprs"),
            "unknown option '--scnee'; did you mean '--scene'?\n"
            "Run 'aprsimd --help' for all options.\n");
  for (const char* typed : {"--any-prot", "--any_port", "--any", "any-port"}) {
    EXPECT_NE(error_of(app, typed).find("did you mean '--any-port'?"), std::string::npos) << typed;
  }
  EXPECT_EQ(error_of(app, "--nothing-like-it").find("did you mean"), std::string::npos);
}

TEST(UsageError, SuggestsTheNearestCommand) {
  std::string file;
  CLI::App app("Tokens", "aprsimd token");
  app.require_subcommand(1);
  app.add_subcommand("add", "")->add_option("--file", file);
  app.add_subcommand("remove", "");
  EXPECT_NE(error_of(app, "remvoe").find("unknown command 'remvoe'; did you mean 'remove'?"),
            std::string::npos);
  EXPECT_NE(error_of(app, "add --fiel x").find("'--fiel'; did you mean '--file'?"),
            std::string::npos);
  EXPECT_NE(error_of(app, "").find("a command is missing: add, remove"), std::string::npos);
}

}  // namespace
}  // namespace aprsim::usage
