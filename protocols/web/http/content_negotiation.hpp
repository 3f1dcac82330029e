#pragma once

#include <string_view>

/// Choice between the representations of a file (RFC 9110, sections 12.5.3 and 13.1.2).
namespace aprsim::web {

/// Whether an Accept-Encoding header permits gzip: by name or by "*", with a weight above 0.
[[nodiscard]] bool accepts_gzip(std::string_view accept_encoding);

/// Whether an If-None-Match header (a list of entity tags or "*") matches `etag`. Compares weakly:
/// the prefix W/ is ignored.
[[nodiscard]] bool matches_etag(std::string_view if_none_match, std::string_view etag);

}  // namespace aprsim::web
