#pragma once

#include <string>
#include <utility>
#include <vector>

#include "world/history/bookmarks.hpp"
#include "world/recorder.hpp"

namespace aprsim::world {

/// Sets bookmarks at what happens: commands, refusals, the world's stop. Thread: sim.
class BookmarkMaker final : public Recorder {
 public:
  /// `robots`: their names, in the scene's order. The bookmarks outlive it.
  BookmarkMaker(Bookmarks& bookmarks, std::vector<std::string> robots)
      : bookmarks_(bookmarks), robots_(std::move(robots)) {}

  void began(RunTime, std::uint64_t, const std::string*) override {}
  void applied(RunTime time, const QueuedCommand& command, const Error* failure) override;
  void sampled(RunTime, StateSample) override {}
  void saved(RunTime, std::uint64_t, std::shared_ptr<const WorldState>) override {}
  void stopped(RunTime time, const std::string& why) override;
  [[nodiscard]] bool wants_checkpoint() const override { return false; }

 private:
  void note(RunTime time, api::BookmarkKind kind, const std::string& text);
  [[nodiscard]] std::string text_of(const api::Command& command) const;

  Bookmarks& bookmarks_;
  std::vector<std::string> robots_;
};

}  // namespace aprsim::world
