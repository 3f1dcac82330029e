#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "aprsim/v1/control_service.pb.h"
#include "clients/aprsim/cli/console.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// Shows the receipt of a command with its step; `done` is its name in JSON, `fields` are further
/// fields.
[[nodiscard]] Outcome<void> show_receipt(
    const char* done, const std::string& what, const Outcome<v1::Receipt>& receipt,
    Console& console, const nlohmann::ordered_json& fields = nlohmann::ordered_json::object());

}  // namespace aprsim::client
