#pragma once

#include <functional>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "aprsim/v1/journal.pb.h"
#include "clients/aprsim/trace/trace.hpp"

namespace aprsim::trace {

/// Selection of the lines of a run.
struct ListingChoice {
  std::string wire;    ///< only this listener; empty = all listeners and the cell's events
  bool polls = false;  ///< include polls and their replies
  std::optional<double> from_s, to_s;  ///< simulated time since the trace's beginning
};

/// One line of a listing.
struct ListedLine {
  double time_s = 0;
  std::string wire;              ///< listener; "cell" for events of the cell
  std::uint64_t connection = 0;  ///< 0 = none
  std::string direction;         ///< "in" from the client, "out" to it; empty = neither
  std::string text;
};

[[nodiscard]] std::string text_of(const ListedLine& line);
[[nodiscard]] nlohmann::ordered_json json_of(const ListedLine& line);

/// Lists a run's journal in its order. Returns a note for everything that is missing. Errors:
/// those of files_of_run().
[[nodiscard]] Result<std::vector<std::string>> list_trace(
    const std::string& place, const ListingChoice& choice,
    const std::function<void(const ListedLine&)>& show);

}  // namespace aprsim::trace
