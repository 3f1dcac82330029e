#pragma once

#include <exception>
#include <string_view>

#include <boost/asio/io_context.hpp>
#include <spdlog/spdlog.h>

namespace aprsim::protocols {

/// Runs a listener's loop until it is stopped or has nothing left to do. A handler that throws
/// costs what it was about at most; the other clients keep their service.
inline void run_loop(boost::asio::io_context& io, std::string_view listener) {
  while (true) {
    try {
      io.run();
      return;
    } catch (const std::exception& problem) {
      spdlog::error("{}: internal error: {}", listener, problem.what());
    }
  }
}

}  // namespace aprsim::protocols
