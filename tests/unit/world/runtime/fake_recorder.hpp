#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "world/runtime/record/recorder.hpp"

namespace aprsim::test {

/// Writes each call down as one line: its name, epoch and step, and what it was told.
class FakeRecorder final : public world::Recorder {
 public:
  void began(world::RunTime time, std::uint64_t seed, const std::string* loaded,
             const std::shared_ptr<const scene::Scene>& /*scene*/) override {
    add("began", time, "seed " + std::to_string(seed) + (loaded ? " " + *loaded : ""));
  }
  void applied(world::RunTime time, const world::QueuedCommand& command,
               const Error* failure) override {
    add("applied", time, std::to_string(command.ticket) + (failure ? " failed" : ""));
  }
  void sampled(world::RunTime time, world::StateSample /*sample*/) override {
    add("sampled", time, "");
  }
  void saved(world::RunTime time, std::uint64_t /*hash*/,
             std::shared_ptr<const world::WorldState> /*state*/) override {
    add("saved", time, "");
  }
  void happened(const api::CellEventPtr& event) override {
    add("happened", {event->epoch, event->step}, std::to_string(event->sequence));
  }
  void stopped(world::RunTime time, const std::string& why) override { add("stopped", time, why); }
  [[nodiscard]] bool wants_checkpoint() const override { return wants; }

  /// The calls since the last time.
  std::vector<std::string> take() { return std::exchange(calls_, {}); }

  bool wants = false;

 private:
  void add(const std::string& name, world::RunTime time, const std::string& more) {
    calls_.push_back(name + " " + std::to_string(time.epoch) + "." + std::to_string(time.step) +
                     (more.empty() ? "" : " " + more));
  }

  std::vector<std::string> calls_;
};

}  // namespace aprsim::test
