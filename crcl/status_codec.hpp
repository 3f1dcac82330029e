#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "crcl/error.hpp"
#include "crcl/framer.hpp"
#include "crcl/status.hpp"

/// Statuses between documents and values.
namespace aprsim::crcl {

/// One CRCLStatus document on one line, elements in schema order, the root without prefix and
/// attributes, doubles in their shortest exact form.
[[nodiscard]] std::string encode_status(const Status& status);

/// Reads one CRCLStatus document, elements in any order, unknown ones ignored. Thread: any.
[[nodiscard]] Result<Status> decode_status(std::string_view document,
                                           std::size_t max_bytes = kMaxStatusBytes);

}  // namespace aprsim::crcl
