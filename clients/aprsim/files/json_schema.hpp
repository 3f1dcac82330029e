#pragma once

#include <nlohmann/json.hpp>

#include "clients/aprsim/files/key_table.hpp"
#include "world/base/yaml/key_recorder.hpp"

namespace aprsim::client {

/// The keys that a kind of file may have, as its readers read them.
[[nodiscard]] const yaml::KeySchema& keys_of(FileKind kind);

/// The JSON schema (draft 7) of a kind of file, with the keys' meanings.
[[nodiscard]] nlohmann::ordered_json json_schema(FileKind kind);

}  // namespace aprsim::client
