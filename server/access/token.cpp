#include "server/access/token.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>

#include "server/config/config_types.hpp"

namespace aprsim::server {
namespace {

tl::unexpected<Error> wrong(const std::string& key, const std::string& what) {
  return fail(ErrorCode::kInvalidArgument, key, key + ": " + what);
}

/// The first line of a file or pipe.
Result<std::string> first_line(const std::string& path) {
  std::ifstream in(path);
  if (!in) return wrong("web.token_file", "cannot read " + path + ": " + std::strerror(errno));
  std::string line;
  for (char c = 0; line.size() <= Secret::kMaxSize && in.get(c) && c != '\n';) line += c;
  if (in.bad()) return wrong("web.token_file", "cannot read " + path);
  if (line.ends_with('\r')) line.pop_back();
  return line;
}

}  // namespace

Result<void> resolve_token(WebConfig& web, const char* environment) {
  if (web.token_file) {
    if (!web.token.empty()) return wrong("web.token_file", "web.token is set, too");
    auto line = first_line(*web.token_file);
    if (!line) return tl::unexpected(line.error());
    web.token = std::move(*line);
  } else if (web.token.empty() && environment != nullptr && *environment != '\0') {
    web.token = environment;
  } else {
    return {};
  }
  if (Secret{8}.accepts(web.token)) return {};
  const std::string expected = "expected " + Secret{8}.text();
  if (!web.token_file) return wrong("APRSIM_TOKEN", expected);
  return wrong("web.token_file", "first line of " + *web.token_file + ": " + expected);
}

}  // namespace aprsim::server
