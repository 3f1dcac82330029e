#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/trace/action.hpp"

/// Two runs of a controller, side by side.
namespace aprsim::trace {

/// In which way a run is not as the other one.
enum class DeviationKind {
  kMissing,   ///< what A did B did not
  kExtra,     ///< what B did A did not
  kOrder,     ///< both did it, at another place
  kValue,     ///< the same command with another value
  kOutcome,   ///< it ended otherwise
  kResult,    ///< it ended well, elsewhere
  kDuration,  ///< it took longer or shorter
  kPause,     ///< it came later or earlier after what was before
  kRead,      ///< only one of both asked for it
  kSeen,      ///< a camera sees something else in the end
  kWire,      ///< one of both has nothing of a wire
};
[[nodiscard]] const char* word_of(DeviationKind kind);

struct Deviation {
  DeviationKind kind = DeviationKind::kValue;
  std::string wire;                               ///< "crcl.fanuc"
  std::optional<std::size_t> number_a, number_b;  ///< of the command on its wire, from 1
  std::string command;                            ///< its kind
  double time_s = 0;                              ///< in A; in B, where A has none
  double since_start_s = 0;                       ///< since the first command of that run
  std::string field;                              ///< of the command
  std::string a, b;                               ///< the field's values, in words
  std::optional<Difference> difference;           ///< of numbers
  double weight = 0;                              ///< how bad it is, in times the tolerance
  std::string text;                               ///< all of it in words
};

struct WireSummary {
  std::string name;
  std::size_t actions_a = 0, actions_b = 0;
  std::size_t pairs = 0;  ///< that were compared
  std::size_t polls_a = 0, polls_b = 0;
  std::size_t deviations = 0;
};

struct Comparison {
  std::vector<Deviation> deviations;  ///< in the order of time
  std::vector<WireSummary> wires;
  std::vector<std::string> notes;  ///< what was not compared, and what is missing

  [[nodiscard]] bool same() const { return deviations.empty(); }
  /// The worst ones, at most so many, worst first.
  [[nodiscard]] std::vector<const Deviation*> worst(std::size_t count) const;
};

/// Aligns robot by robot and wire by wire.
[[nodiscard]] Comparison compare(const Trace& a, const Trace& b, const Tolerance& tolerance);

}  // namespace aprsim::trace
