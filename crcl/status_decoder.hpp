#pragma once

#include <cstddef>
#include <string_view>

#include "crcl/error.hpp"
#include "crcl/framer.hpp"
#include "crcl/status.hpp"

namespace aprsim::crcl {

/// Reads one CRCLStatus document, elements in any order, unknown ones ignored. Thread: any.
[[nodiscard]] Result<Status> decode_status(std::string_view document,
                                           std::size_t max_bytes = kMaxStatusBytes);

}  // namespace aprsim::crcl
