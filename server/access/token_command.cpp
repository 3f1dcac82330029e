#include "server/access/token_command.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "server/access/access_file.hpp"
#include "world/base/usage/usage_error.hpp"

namespace aprsim::server {
namespace {

using protocols::WallTime;

constexpr const char* kVariable = "APRSIM_ACCESS_FILE";

/// Parses a time, or days from now as in 30d; empty = never.
std::optional<WallTime> expiry_of(const std::string& text) {
  if (text.empty()) return std::nullopt;
  int days = 0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, days);
  constexpr int kMostDays = 36'500;
  if (read.ec == std::errc{} && read.ptr + 1 == end && *read.ptr == 'd' && days > 0 &&
      days <= kMostDays) {
    return std::chrono::system_clock::now() + std::chrono::hours(24) * days;
  }
  const auto time = time_of(text);
  if (!time)
    throw CLI::ValidationError("--expires",
                               "'" + text +
                                   "' is neither a time such as "
                                   "2027-01-31T12:00:00Z, nor a date, nor days such as 30d");
  if (*time <= std::chrono::system_clock::now()) {
    throw CLI::ValidationError("--expires", text + " is over");
  }
  return time;
}

struct Asked {
  std::string file, name, role, expires;
  bool certificate = false;
};

/// Content of a file; empty where it does not exist yet.
Result<AccessFile> present(const std::string& path) {
  if (!std::filesystem::exists(path)) return AccessFile{};
  return read_access_file(path);
}

Result<void> add(const Asked& asked, std::optional<WallTime> expires, std::ostream& out,
                 std::ostream& err) {
  auto file = present(asked.file);
  if (!file) return tl::unexpected(file.error());
  const auto taken = [&](const auto& entry) { return entry.name == asked.name; };
  const protocols::Role role = *protocols::role_of(asked.role);
  const bool again = asked.certificate ? std::ranges::any_of(file->certificates, taken)
                                       : std::ranges::any_of(file->tokens, taken);
  if (again) {
    return fail(ErrorCode::kFailedPrecondition, "name",
                fmt::format("{} is in {} already; remove it first", asked.name, asked.file));
  }
  if ((asked.certificate ? file->certificates.size() : file->tokens.size()) >=
      AccessFile::kMaxEntries) {
    return fail(
        ErrorCode::kFailedPrecondition, "name",
        fmt::format("{} has {} entries, which is the limit", asked.file, AccessFile::kMaxEntries));
  }
  std::string token;
  if (asked.certificate) {
    file->certificates.push_back({asked.name, role});
  } else {
    token = random_token();
    file->tokens.push_back(entry_of(token, asked.name, role, expires));
  }
  if (auto ok = write_access_file(asked.file, *file); !ok) return ok;
  if (asked.certificate) {
    out << fmt::format("certificates of {} have the role {}\n", asked.name, asked.role);
    return {};
  }
  // Standard output has the token alone, for redirection to a file.
  out << token << '\n';
  err << fmt::format("token {} has the role {}{}; it is shown only now\n", asked.name, asked.role,
                     expires ? " until " + text_of(*expires) : "");
  return {};
}

Result<void> list(const Asked& asked, std::ostream& out) {
  const auto file = read_access_file(asked.file);
  if (!file) return tl::unexpected(file.error());
  const auto now = std::chrono::system_clock::now();
  for (const auto& token : file->tokens) {
    const std::string end = !token.expires          ? "never expires"
                            : *token.expires <= now ? "expired " + text_of(*token.expires)
                                                    : "until " + text_of(*token.expires);
    out << fmt::format("token        {:<24} {:<8} {}\n", token.name, protocols::to_text(token.role),
                       end);
  }
  for (const auto& entry : file->certificates) {
    out << fmt::format("certificate  {:<24} {}\n", entry.name, protocols::to_text(entry.role));
  }
  return {};
}

Result<void> remove(const Asked& asked, std::ostream& out) {
  auto file = read_access_file(asked.file);
  if (!file) return tl::unexpected(file.error());
  const auto named = [&](const auto& entry) { return entry.name == asked.name; };
  const auto removed = asked.certificate ? std::erase_if(file->certificates, named)
                                         : std::erase_if(file->tokens, named);
  if (removed == 0) {
    return fail(ErrorCode::kNotFound, "name",
                fmt::format("{} is not in {}", asked.name, asked.file));
  }
  if (auto ok = write_access_file(asked.file, *file); !ok) return ok;
  out << fmt::format("{} removed; a running daemon applies this on SIGHUP\n", asked.name);
  return {};
}

}  // namespace

int token_command(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
  CLI::App app{
      "aprsimd token: creates, lists and removes access tokens for gRPC and the page. A token is "
      "shown once; the file keeps its hash.",
      "aprsimd token"};
  app.require_subcommand(1);
  Asked asked;
  if (const char* variable = std::getenv(kVariable)) asked.file = variable;
  const auto with_file = [&](CLI::App* command) {
    auto* file = command->add_option("--file", asked.file,
                                     fmt::format("Access file (default: ${})", kVariable));
    if (asked.file.empty()) file->required();
    command->add_flag(
        "--certificate", asked.certificate,
        "Treat NAME as a name in client certificates (common or alternative) instead of a token");
    return command;
  };
  CLI::App* adding = with_file(app.add_subcommand("add", "Create a token and print it"));
  CLI::App* listing = app.add_subcommand("list", "List names, roles and expiry dates");
  auto* listed = listing->add_option("--file", asked.file, "Access file");
  if (asked.file.empty()) listed->required();
  CLI::App* removing = with_file(app.add_subcommand("remove", "Remove a token"));
  for (CLI::App* command : {adding, removing}) {
    command->add_option("NAME", asked.name, "Name of the token's holder")
        ->required()
        ->check(CLI::Validator(
            [&](std::string& text) {
              return asked.certificate || is_token_name(text)
                         ? std::string()
                         : "'" + text + "' is not 1 to 64 letters, digits and . _ - @";
            },
            ""));
  }
  adding->add_option("--role", asked.role, "Role of the holder; each role includes those before it")
      ->required()
      ->check(CLI::IsMember({"view", "operate", "inject", "admin"}));
  adding->add_option("--expires", asked.expires,
                     "Expiry: a time, a date, or days from now as in 30d");
  try {
    auto reversed = arguments;
    std::ranges::reverse(reversed);
    app.parse(std::move(reversed));
    const auto expires = expiry_of(asked.expires);
    const auto done = adding->parsed()    ? add(asked, expires, out, err)
                      : listing->parsed() ? list(asked, out)
                                          : remove(asked, out);
    if (done) return EXIT_SUCCESS;
    err << "aprsimd: " << done.error().message << '\n';
    return EXIT_FAILURE;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, out, err);
    err << "aprsimd token: " << usage::usage_error(app, error);
    return 2;
  }
}

}  // namespace aprsim::server
