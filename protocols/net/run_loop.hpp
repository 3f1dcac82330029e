#pragma once

#include <exception>
#include <string_view>

#include <boost/asio/io_context.hpp>
#include <spdlog/spdlog.h>

namespace aprsim::protocols {

/// Runs a listener's loop until it is stopped or has no work left. An exception of a handler is
/// logged and affects only that handler's client.
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
