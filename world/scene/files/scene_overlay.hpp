#pragma once

#include "world/base/yaml/yaml_tree.hpp"

namespace aprsim::scene {

/// Lays the tree of a scene over that of its base. Maps are joined key by key; in lists of named
/// things an entry changes the one of its name or is appended; anything else is replaced.
void lay_over(yaml::detail::Value& base, yaml::detail::Value over);

}  // namespace aprsim::scene
