#pragma once

#include <iosfwd>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/cli/screen.hpp"
#include "clients/wires/endpoints.hpp"

namespace aprsim::client {

/// What a command finds and where its results go, line by line.
struct Console {
  Endpoints endpoints;
  std::string ports_file;  ///< that they are from; empty = none
  std::ostream& out;
  bool json = false;
  Screen screen = {};

  /// One result, at once: as lines of text, or with --json as one object on a line of its own.
  void show(const std::string& text, const nlohmann::ordered_json& object);
};

}  // namespace aprsim::client
