#pragma once

#include <vector>

#include "aprsim/v1/history_service.pb.h"
#include "world/api/commands/simulation_command.hpp"
#include "world/api/ports/history.hpp"

/// The history as messages of aprsim.v1.
namespace aprsim::protocols {

void write_message(const std::vector<api::HistorySpan>& spans, v1::GetHistoryResponse& message);
void write_message(const api::Bookmark& bookmark, v1::Bookmark& message);
void write_message(const std::vector<api::Bookmark>& bookmarks, v1::ListBookmarksResponse& message);
[[nodiscard]] api::Moment to_moment(const v1::Moment& message);

/// The command that restores the cell at a computed moment.
[[nodiscard]] api::LoadState resumption(api::Moment moment, const api::PastMoment& past);

}  // namespace aprsim::protocols
