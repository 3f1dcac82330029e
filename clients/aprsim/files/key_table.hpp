#pragma once

#include <string>

/// Meanings of the keys of scene and scenario files: docs/site/scene_keys.txt and
/// scenario_keys.txt.
namespace aprsim::client {

enum class FileKind { kScene, kTypes, kScenario };

/// The meaning of a key and what its values are, in one line; empty if no table has it. `pattern`
/// is as in robots[].vision.area and pockets.*.depth_m.
[[nodiscard]] std::string meaning_of(FileKind kind, const std::string& pattern);

}  // namespace aprsim::client
