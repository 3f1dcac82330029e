#pragma once

#include <string>

/// The table of kinds for readers.
namespace aprsim::faults {

/// FAULTS.md.
[[nodiscard]] std::string markdown();

/// A number as people write it: "0.3", "10", "-3.14159".
[[nodiscard]] std::string number_text(double value);

}  // namespace aprsim::faults
