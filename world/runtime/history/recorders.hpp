#pragma once

#include <memory>
#include <string>
#include <vector>

#include "world/runtime/record/recorder.hpp"

namespace aprsim::world {

/// Tells several recorders what one hears. A checkpoint that only one of them has asked for is for
/// that one. Thread: sim.
class Recorders final : public Recorder {
 public:
  /// They outlive it; null ones are left out.
  explicit Recorders(const std::vector<Recorder*>& all);

  void began(RunTime time, std::uint64_t seed, const std::string* loaded,
             const std::shared_ptr<const scene::Scene>& scene) override;
  void applied(RunTime time, const QueuedCommand& command, const Error* failure) override;
  void sampled(RunTime time, StateSample sample) override;
  void saved(RunTime time, std::uint64_t hash, std::shared_ptr<const WorldState> state) override;
  void happened(const api::CellEventPtr& event) override;
  void stopped(RunTime time, const std::string& why) override;
  [[nodiscard]] bool wants_checkpoint() const override;

 private:
  std::vector<Recorder*> all_;
  bool began_ = false;  ///< the next checkpoint is for everybody
};

}  // namespace aprsim::world
