#pragma once

#include "server/config/config.hpp"
#include "world/base/result.hpp"

namespace aprsim::server {

/// Reads the access token from where the configuration says: from web.token_file, or, when that and
/// web.token are empty, from `environment`, the value of APRSIM_TOKEN or null. Errors name the key,
/// the file and what is wrong with it, never the token.
[[nodiscard]] Result<void> resolve_token(WebConfig& web, const char* environment);

}  // namespace aprsim::server
