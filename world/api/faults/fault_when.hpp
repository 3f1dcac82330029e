#pragma once

#include <string>
#include <variant>

#include <tl/expected.hpp>

namespace aprsim::faults {

/// Triggers of faults as people write them; see aprsim.v1.InjectFaultRequest.
struct WhenPlaced {
  std::string type, robot;  ///< robot empty = any
};
struct WhenGrasped {
  std::string robot;
  unsigned count = 1;
};
struct WhenBeamBroken {
  std::string eye;
};
struct WhenReported {
  std::string event;
};
struct WhenCrossing {
  std::string quantity, robot;
  unsigned joint = 0;  ///< from 1, where one is named
  bool above = true;
  double limit = 0;
};
using FaultWhen = std::variant<WhenPlaced, WhenGrasped, WhenBeamBroken, WhenReported, WhenCrossing>;

/// "placed:TYPE[:ROBOT]", "grasp:ROBOT[:N]", "beam:EYE", "event:NAME", or
/// "QUANTITY[:ROBOT[:JOINT]]" with > or < and a limit. The error says what is wrong with the text.
[[nodiscard]] tl::expected<FaultWhen, std::string> parse_when(const std::string& text);

}  // namespace aprsim::faults
