#pragma once

#include "clients/aprsim/text/paint.hpp"

namespace aprsim::client {

/// Properties of standard output and standard error.
struct Screen {
  bool live = false;  ///< standard output is a terminal whose lines can be rewritten
  Paint out, err;     ///< colours, on terminals unless NO_COLOR is set

  /// The screen of this process.
  [[nodiscard]] static Screen of_process();
};

}  // namespace aprsim::client
