#pragma once

#include <span>
#include <string_view>

#include "crcl/commands.hpp"
#include "crcl/fields.hpp"

namespace aprsim::crcl {

/// How the elements of one command type are read.
struct CommandReader {
  std::string_view type;  ///< xsi:type
  CommandBody (*read)(const Fields& command);
};

/// Of the types in crcl/service_commands.hpp.
[[nodiscard]] std::span<const CommandReader> service_readers();

}  // namespace aprsim::crcl
