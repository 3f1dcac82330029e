#pragma once

#include "clients/aprsim/text/paint.hpp"

namespace aprsim::client {

/// What standard output and standard error are connected to.
struct Screen {
  bool live = false;  ///< standard output is a terminal whose lines can be written over
  Paint out, err;     ///< colours, where there is a terminal and NO_COLOR is not set

  /// Of this process.
  [[nodiscard]] static Screen of_process();
};

}  // namespace aprsim::client
