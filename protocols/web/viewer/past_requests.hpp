#pragma once

#include <functional>
#include <optional>
#include <string>

#include "protocols/web/topics/scene_appearance.hpp"
#include "protocols/web/viewer/past_query_queue.hpp"
#include "protocols/web/viewer/viewer.hpp"
#include "protocols/web/viewer/web_options.hpp"

namespace aprsim::web {

/// Viewers' requests about the past: queries for moments, returns to a moment, bookmarks.
/// Thread: the server's.
class PastRequests {
 public:
  /// Both must outlive this object.
  PastRequests(const WebServerOptions& options, const std::string& instance_id)
      : options_(options), instance_id_(instance_id), queries_(options.history) {}

  /// Executes a request about the past; all but those about bookmarks are answered later. Absent =
  /// another kind of request. Error: kFailedPrecondition where no history is kept.
  [[nodiscard]] std::optional<Result<void>> execute(const Viewer& viewer,
                                                    const v1::ViewerRequest& request);
  using Answer = PastQueryQueue::Answer;
  [[nodiscard]] std::vector<Answer> take_answers() { return queries_.take_answers(); }
  /// Writes a requested moment; `present` is the current description of the cell.
  void write(const Answer& answer, const api::CellDescription& present, v1::PastSnapshot& message);
  void forget(std::uint64_t viewer) { queries_.forget(viewer); }

 private:
  const WebServerOptions& options_;
  const std::string& instance_id_;
  PastQueryQueue queries_;
  SceneAppearance appearance_;
};

}  // namespace aprsim::web
