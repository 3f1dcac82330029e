#include "protocols/web/http/request_target.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "protocols/web/http/origin_check.hpp"

namespace aprsim::web {
namespace {

/// Value of "%41" at the start of `text`; nullopt where two hexadecimal digits are missing.
std::optional<char> escaped_byte(std::string_view text) {
  if (text.size() < 3) return std::nullopt;
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + 3, value, 16);
  if (error != std::errc() || end != text.data() + 3) return std::nullopt;
  return static_cast<char>(value);
}

/// Decodes percent escapes once. An escaped slash is data, not a separator, so it stays escaped.
std::optional<std::string> decoded(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    if (text.front() != '%') {
      out += text.front();
      text.remove_prefix(1);
      continue;
    }
    const auto byte = escaped_byte(text);
    if (!byte) return std::nullopt;
    if (*byte == '/' || *byte == '\0') {
      out += text.substr(0, 3);
    } else {
      out += *byte;
    }
    text.remove_prefix(3);
  }
  return out;
}

/// Removes "http://" or "https://", in any case; false where `target` has no such prefix.
bool remove_scheme(std::string_view& target) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (is_equal_ignoring_case(target.substr(0, scheme.size()), scheme)) {
      target.remove_prefix(scheme.size());
      return true;
    }
  }
  return false;
}

tl::unexpected<Error> bad(std::string field, std::string why) {
  return fail(ErrorCode::kInvalidArgument, std::move(field), std::move(why));
}

}  // namespace

Result<RequestTarget> read_target(std::string_view target, std::span<const std::string_view> hosts,
                                  unsigned version) {
  if (hosts.size() > 1) return bad("Host", "more than one Host header");
  if (hosts.empty() && version >= 11) return bad("Host", "HTTP/1.1 needs a Host header");
  std::string_view host = hosts.empty() ? std::string_view{} : hosts.front();
  if (!host.empty() && !is_host(host)) return bad("Host", "not a host with an optional port");

  RequestTarget result;
  if (remove_scheme(target)) {
    const std::size_t end = std::min(target.find_first_of("/?#"), target.size());
    host = target.substr(0, end);
    if (!is_host(host)) return bad("target", "its host is not a host with an optional port");
    target.remove_prefix(end);
    if (!target.starts_with('/')) result.path = "/";
  }
  result.host = host;
  target = target.substr(0, target.find('#'));
  const std::size_t mark = std::min(target.find('?'), target.size());
  auto path = decoded(target.substr(0, mark));
  auto query = decoded(target.substr(std::min(mark + 1, target.size())));
  if (!path || !query) return bad("target", "a percent sign needs two hexadecimal digits");
  result.path += *path;
  result.query = *std::move(query);
  return result;
}

}  // namespace aprsim::web
