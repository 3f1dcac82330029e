#include "world/runtime/history/recorders.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace aprsim::world {

Recorders::Recorders(const std::vector<Recorder*>& all) {
  std::ranges::copy_if(all, std::back_inserter(all_),
                       [](const Recorder* r) { return r != nullptr; });
}

void Recorders::began(RunTime time, std::uint64_t seed, const std::string* loaded,
                      const std::shared_ptr<const scene::Scene>& scene) {
  began_ = true;
  for (Recorder* recorder : all_) recorder->began(time, seed, loaded, scene);
}

void Recorders::applied(RunTime time, const QueuedCommand& command, const Error* failure) {
  for (Recorder* recorder : all_) recorder->applied(time, command, failure);
}

void Recorders::sampled(RunTime time, StateSample sample) {
  for (Recorder* recorder : all_) recorder->sampled(time, sample);
}

void Recorders::saved(RunTime time, std::uint64_t hash, std::shared_ptr<const WorldState> state) {
  const bool due = std::exchange(began_, false) || time.step % kCheckpointSteps == 0;
  for (Recorder* recorder : all_) {
    if (due || recorder->wants_checkpoint()) recorder->saved(time, hash, state);
  }
}

void Recorders::happened(const api::CellEventPtr& event) {
  for (Recorder* recorder : all_) recorder->happened(event);
}

void Recorders::stopped(RunTime time, const std::string& why) {
  for (Recorder* recorder : all_) recorder->stopped(time, why);
}

bool Recorders::wants_checkpoint() const {
  return std::ranges::any_of(all_, [](const Recorder* r) { return r->wants_checkpoint(); });
}

}  // namespace aprsim::world
