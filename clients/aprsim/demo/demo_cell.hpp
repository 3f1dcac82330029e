#pragma once

#include <chrono>
#include <functional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/demo/cell_view.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {

/// The demo's access to the cell and its output.
struct DemoCell {
  CellConnection& connection;
  const v1::CellDescription& description;
  Console& console;

  [[nodiscard]] Outcome<CellView> view() const;

  /// Polls snapshots until `met` returns true; false on timeout. Failure kInterrupted after an
  /// interruption.
  [[nodiscard]] Outcome<bool> wait_until(const std::function<bool(const v1::Snapshot&)>& met,
                                         std::chrono::milliseconds limit) const;

  /// Reports an action: "source: text", or as JSON {"source", "action", fields...}; null = no
  /// fields.
  void report(const std::string& source, const char* action, const std::string& text,
              const nlohmann::ordered_json& fields) const;
};

}  // namespace aprsim::client
