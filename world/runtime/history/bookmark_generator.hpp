#pragma once

#include <memory>
#include <string>

#include "world/runtime/history/bookmarks.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::world {

/// Sets bookmarks at events of the cell, and at commands and failures that no event reports.
/// Thread: sim.
class BookmarkGenerator final : public Recorder {
 public:
  /// The bookmarks outlive it.
  explicit BookmarkGenerator(Bookmarks& bookmarks) : bookmarks_(bookmarks) {}

  void began(RunTime, std::uint64_t, const std::string*,
             const std::shared_ptr<const scene::Scene>&) override {}
  void applied(RunTime time, const QueuedCommand& command, const Error* failure) override;
  void sampled(RunTime, StateSample) override {}
  void saved(RunTime, std::uint64_t, std::shared_ptr<const WorldState>) override {}
  void happened(const api::CellEventPtr& event) override;
  void stopped(RunTime, const std::string&) override {}
  [[nodiscard]] bool wants_checkpoint() const override { return false; }

 private:
  void add(api::Moment moment, api::BookmarkKind kind, const std::string& text);

  Bookmarks& bookmarks_;
};

}  // namespace aprsim::world
