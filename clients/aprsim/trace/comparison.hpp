#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/trace/action.hpp"

/// Comparison of two runs of a controller.
namespace aprsim::trace {

/// Kinds of differences between two runs.
enum class DeviationKind {
  kMissing,   ///< only in A
  kExtra,     ///< only in B
  kOrder,     ///< in both, at different positions
  kValue,     ///< same command, different value
  kOutcome,   ///< different outcome
  kResult,    ///< success with a different result
  kDuration,  ///< different duration
  kPause,     ///< different pause since the previous action
  kRead,      ///< register read in one run only
  kSeen,      ///< different final scene in a camera
  kWire,      ///< a listener without traffic in one run
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
  double weight = 0;                              ///< severity as a multiple of the tolerance
  std::string text;                               ///< full description
};

struct WireSummary {
  std::string name;
  std::size_t actions_a = 0, actions_b = 0;
  std::size_t pairs = 0;  ///< compared actions
  std::size_t polls_a = 0, polls_b = 0;
  std::size_t deviations = 0;
};

struct Comparison {
  std::vector<Deviation> deviations;  ///< in the order of time
  std::vector<WireSummary> wires;
  std::vector<std::string> notes;  ///< parts that were not compared or are missing

  [[nodiscard]] bool same() const { return deviations.empty(); }
  /// The `most` worst deviations, worst first.
  [[nodiscard]] std::vector<const Deviation*> worst(std::size_t count) const;
};

/// Aligns robot by robot and wire by wire.
[[nodiscard]] Comparison compare(const Trace& a, const Trace& b, const Tolerance& tolerance);

}  // namespace aprsim::trace
