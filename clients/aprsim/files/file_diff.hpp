#pragma once

#include <string>
#include <vector>

#include "clients/aprsim/files/scene_files.hpp"

namespace aprsim::client {

/// One difference of two files, as a reader of both would tell it.
struct Difference {
  enum class Kind { kAdded, kRemoved, kMoved, kChanged };
  Kind kind = Kind::kChanged;
  std::string key;            ///< as in trays.kit_1 and physics.friction.gear_tray
  std::string before, after;  ///< as in the files; empty = not there
  std::string unit;           ///< of both; empty = none
  double moved_m = 0;         ///< of kMoved
};

/// The differences of what two valid files of one kind describe. Types count where they are used,
/// whichever file they are in; things in lists are found by their names; the order of keys and
/// things, and defaults that only one file spells out, are no differences. Error: a file that
/// cannot be read.
[[nodiscard]] Outcome<std::vector<Difference>> diff_files(const FoundFile& before,
                                                          const FoundFile& after,
                                                          const scene::DataPaths& paths);

/// One line, without its end.
[[nodiscard]] std::string text_of(const Difference& difference);

}  // namespace aprsim::client
