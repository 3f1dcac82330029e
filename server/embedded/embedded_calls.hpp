#pragma once

#include <string>
#include <string_view>

#include "server/embedded/embedded_cell.hpp"

namespace aprsim::embedded {

/// A gRPC status.
struct CallStatus {
  int code = 0;  ///< 0 = OK
  std::string text = {};
};

/// Performs a call of aprsim.v1 that has one request and one answer, with the messages and errors
/// of the daemon. `method`: such as "Control/Step". `answer`: the bytes of its message, where the
/// code is 0. `after_step`: see EmbeddedCell::take_steps(). Thread: that of the cell.
[[nodiscard]] CallStatus call(EmbeddedCell& cell, std::string_view method, std::string_view request,
                              const AfterStep& after_step, std::string& answer);

}  // namespace aprsim::embedded
