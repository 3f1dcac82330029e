#pragma once

#include <iosfwd>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/cli/screen.hpp"
#include "clients/wires/endpoints.hpp"

namespace aprsim::client {

/// The endpoints of a command, and its output.
/// Texts come from wires, files and other programs: control characters are escaped, except this
/// program's own colours.
struct Console {
  Endpoints endpoints;
  std::string ports_file;  ///< the ports file of the endpoints; empty = none
  std::ostream& out;
  bool json = false;
  Screen screen = {};
  int output_error = 0;  ///< the errno of the first write that failed; 0 = none

  /// Writes one result at once: its text, or with --json the object on a line of its own.
  void show(const std::string& text, const nlohmann::ordered_json& object);
  /// Writes text at once.
  void print(std::string_view text);
  /// Writes one JSON object at once, on a line of its own.
  void print_json(const nlohmann::ordered_json& object);
  /// The text with control characters escaped.
  [[nodiscard]] std::string escaped(std::string_view text) const;

  /// Writes bytes as they are, for documents of this program and for files.
  void write(std::string_view bytes);
};

}  // namespace aprsim::client
