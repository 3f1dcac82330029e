#pragma once

#include <span>
#include <string>
#include <string_view>

/// Which requests may come from a browser: pages of other sites must neither read nor command.
namespace aprsim::web {

/// Whether a Host header names this daemon: a numeric address, localhost, or one of `names`, with
/// any port. Another name could be a foreign site's that has been made to lead here.
[[nodiscard]] bool is_own_host(std::string_view host, std::span<const std::string> names);

/// Whether an Origin header is the page of that host itself. Programs send none: they may connect.
[[nodiscard]] bool is_same_origin(std::string_view origin, std::string_view host);

}  // namespace aprsim::web
