#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "protocols/ports/refusal_sink.hpp"
#include "server/journal/journal.hpp"
#include "world/api/ports/ports.hpp"
#include "world/base/rate_limit.hpp"
#include "world/runtime/history/bookmarks.hpp"

namespace aprsim::server {

/// Records a bookmark and a journal event where a listener refuses a request. Each listener gets
/// kBurst, then kPerSecond, so that a client that retries cannot displace other bookmarks. Thread:
/// any.
class RejectionBookmarks final : public protocols::RefusalSink {
 public:
  static constexpr double kBurst = 20, kPerSecond = 0.2;

  /// All arguments outlive it; the journal may be null.
  RejectionBookmarks(world::Bookmarks& bookmarks, journal::Journal* journal,
                     const api::SnapshotSource& source)
      : bookmarks_(bookmarks), journal_(journal), source_(source) {}

  void refused(std::string_view source, std::string_view what) override;

 private:
  world::Bookmarks& bookmarks_;
  journal::Journal* const journal_;
  const api::SnapshotSource& source_;
  std::mutex mutex_;
  std::map<std::string, protocols::RateLimit, std::less<>> limits_;  ///< by listener
};

}  // namespace aprsim::server
