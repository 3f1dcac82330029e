#include "protocols/web/http/origin_check.hpp"

#include <algorithm>
#include <cctype>

#include <boost/asio/ip/address.hpp>

namespace aprsim::web {
namespace {

/// A fully qualified name may end with one dot, the root of DNS.
std::string_view without_final_dot(std::string_view name) {
  if (name.size() > 1 && name.ends_with('.')) name.remove_suffix(1);
  return name;
}

/// "[::1]:8080" -> "::1", "localhost.:8080" -> "localhost"; empty where `host` is malformed.
std::string_view host_name(std::string_view host) {
  std::string_view name, rest;
  if (host.starts_with('[')) {
    const auto end = host.find(']');
    if (end == std::string_view::npos) return {};
    name = host.substr(1, end - 1);
    rest = host.substr(end + 1);
  } else {
    const auto colon = std::min(host.find(':'), host.size());
    name = host.substr(0, colon);
    rest = host.substr(colon);
  }
  const bool port = rest.empty() || (rest.front() == ':' &&
                                     std::all_of(rest.begin() + 1, rest.end(),
                                                 [](unsigned char c) { return std::isdigit(c); }));
  if (!port || name.find_first_of(" \t@/\\") != std::string_view::npos) return {};
  return without_final_dot(name);
}

}  // namespace

bool is_equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

bool is_host(std::string_view text) { return !host_name(text).empty(); }

bool is_own_host(std::string_view host, std::span<const std::string> names) {
  const std::string_view name = host_name(host);
  if (name.empty()) return false;
  if (is_equal_ignoring_case(name, "localhost")) return true;
  boost::system::error_code error;
  (void)boost::asio::ip::make_address(std::string(name), error);
  if (!error) return true;
  return std::any_of(names.begin(), names.end(), [&](const std::string& known) {
    return is_equal_ignoring_case(without_final_dot(known), name);
  });
}

bool is_same_origin(std::string_view origin, std::string_view host) {
  if (origin.empty()) return true;
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (origin.starts_with(scheme))
      return is_equal_ignoring_case(origin.substr(scheme.size()), host);
  }
  return false;
}

}  // namespace aprsim::web
