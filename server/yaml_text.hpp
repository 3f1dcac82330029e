#pragma once

#include <cstdint>
#include <map>
#include <string>

/// Parts of a printed configuration.
namespace aprsim::server {

/// A text as YAML that reads back to the same: quoted unless it is an ordinary word.
[[nodiscard]] std::string scalar(const std::string& text);

/// Ports by name, a line each, indented by four; an empty map when there are none.
[[nodiscard]] std::string ports_text(const std::map<std::string, std::uint16_t>& ports);

}  // namespace aprsim::server
