#pragma once

#include <span>
#include <string>
#include <string_view>

/// Protection against pages of other sites: they must neither read from the daemon nor command it.
namespace aprsim::web {

[[nodiscard]] bool is_equal_ignoring_case(std::string_view a, std::string_view b);

/// Whether a text is a host with an optional port ("cell:80", "[::1]:80", "127.0.0.1").
[[nodiscard]] bool is_host(std::string_view text);

/// Whether a Host header names this daemon: a numeric address, localhost, or one of `names`, with
/// any port. A final dot is ignored. Any other name could belong to a foreign site whose DNS entry
/// points to this machine (DNS rebinding).
[[nodiscard]] bool is_own_host(std::string_view host, std::span<const std::string> names);

/// Whether an Origin header names the page of that host. Programs send no Origin and are accepted.
[[nodiscard]] bool is_same_origin(std::string_view origin, std::string_view host);

}  // namespace aprsim::web
