#pragma once

#include "aprsim/v1/control_service.pb.h"
#include "world/api/description/cell_description.hpp"
#include "world/api/ports/move_previews.hpp"

/// Previews of moves as messages of aprsim.v1.
namespace aprsim::protocols {

/// Errors name the field, the value and what was expected. Ranges are checked where the preview is
/// requested.
[[nodiscard]] Result<api::PreviewRequest> to_preview(const v1::PreviewMoveRequest& request,
                                                     const api::CellDescription& cell);

/// The message must be empty.
void write_message(const api::MovePreview& preview, v1::PreviewMoveResponse& message);

}  // namespace aprsim::protocols
