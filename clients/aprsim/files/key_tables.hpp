#pragma once

#include <string_view>

namespace aprsim::client {

/// The files docs/site/scene_keys.txt and scenario_keys.txt, compiled in.
[[nodiscard]] std::string_view scene_key_table();
[[nodiscard]] std::string_view scenario_key_table();

}  // namespace aprsim::client
