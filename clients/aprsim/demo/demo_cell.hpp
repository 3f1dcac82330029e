#pragma once

#include <chrono>
#include <functional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/demo/cell_view.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {

/// What the demo knows of the cell while it works, and how it tells what it does.
struct DemoCell {
  CellConnection& connection;
  const v1::CellDescription& description;
  Console& console;

  [[nodiscard]] Outcome<CellView> look() const;

  /// Looks again and again until `met` says true; false when that takes longer than the limit. Ends
  /// with kInterrupted when the user interrupts it.
  [[nodiscard]] Outcome<bool> look_until(const std::function<bool(const v1::Snapshot&)>& met,
                                         std::chrono::milliseconds limit) const;

  /// One thing done: "who: text", or for programs {"who", "event", fields...};
  /// no fields is null.
  void tell(const std::string& who, const char* event, const std::string& text,
            const nlohmann::ordered_json& fields) const;
};

}  // namespace aprsim::client
