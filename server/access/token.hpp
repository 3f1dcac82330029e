#pragma once

#include "server/config/config.hpp"
#include "world/base/result.hpp"

namespace aprsim::server {

/// Reads the access token from web.token_file, or, where that and web.token are empty, from
/// `environment`, the value of APRSIM_TOKEN or null. Errors name key, file and problem, never the
/// token.
[[nodiscard]] Result<void> resolve_token(WebConfig& web, const char* environment);

}  // namespace aprsim::server
