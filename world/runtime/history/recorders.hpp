#pragma once

#include <memory>
#include <string>
#include <vector>

#include "world/runtime/record/recorder.hpp"

namespace aprsim::world {

/// Forwards all records to several recorders. A checkpoint goes only to the recorders that wanted
/// it. Thread: sim.
class Recorders final : public Recorder {
 public:
  /// The recorders outlive this object; null ones are ignored.
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
  bool began_ = false;  ///< the next checkpoint goes to all
};

}  // namespace aprsim::world
