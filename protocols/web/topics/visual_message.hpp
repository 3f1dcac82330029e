#pragma once

#include "aprsim/v1/web.pb.h"
#include "protocols/web/topics/visual_description.hpp"

namespace aprsim::web {

/// Copies each field into a message, which must be empty.
void write_message(const VisualDescription& visual, v1::CellAppearance& message);

}  // namespace aprsim::web
