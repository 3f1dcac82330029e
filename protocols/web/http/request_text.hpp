#pragma once

#include <string>

#include "aprsim/v1/web.pb.h"
#include "world/api/description/cell_description.hpp"

/// Requests of viewers as the record of commands shows them.
namespace aprsim::web {

/// The request in a few words, as the protocol calls it: "pause", "fanuc move_tool".
[[nodiscard]] std::string title_of(const v1::ViewerRequest& request,
                                   const api::CellDescription& cell);
/// All of it as JSON.
[[nodiscard]] std::string json_of(const v1::ViewerRequest& request);

}  // namespace aprsim::web
