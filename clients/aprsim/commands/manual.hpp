#pragma once

#include <string>

namespace aprsim::client {

/// The manual page aprsim(1), in mdoc.
[[nodiscard]] std::string manual_page();

}  // namespace aprsim::client
