#pragma once

#include <string>

#include "crcl/documents.hpp"
#include "crcl/status.hpp"

namespace aprsim::crcl {

/// One CRCLCommandInstance document on one line, elements in schema order.
[[nodiscard]] std::string encode_command(const CommandInstance& instance);

/// One CRCLStatus document on one line, elements in schema order, the root without prefix and
/// attributes, doubles in their shortest exact form.
[[nodiscard]] std::string encode_status(const Status& status);

}  // namespace aprsim::crcl
