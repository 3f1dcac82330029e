#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "protocols/ports/program_runner.hpp"

namespace aprsim::server {

inline constexpr std::size_t kMostOrders = 64;        ///< orders that are shown
inline constexpr std::size_t kMostLines = 100;        ///< lines of output that are kept
inline constexpr std::size_t kLongestText = 200;      ///< bytes of a line or name
inline constexpr std::size_t kLongestReport = 16384;  ///< bytes

/// Updates the status by a line of a program's output: a JSON object with "progress" ("time_s",
/// "placed", and "orders" with "name", "tray", "state", "kits", "done", "parts", "parts_wanted"),
/// with "event" (and "time_s"), with "text" (and "source"), or with "report". Values of another
/// type are ignored, long ones are cut. Returns a line that is no JSON, for the log.
[[nodiscard]] std::optional<std::string> take_line(std::string_view line,
                                                   web::ProgramStatus& status);

}  // namespace aprsim::server
