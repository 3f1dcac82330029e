#include "tests/support/recorded_demo.hpp"

#include <memory>
#include <utility>
#include <variant>

namespace aprsim::test {

RecordedDemo::RecordedDemo(world::World& world, world::Recorder& recorder, std::uint64_t seed)
    : world_(world), recorder_(recorder), demo_(world) {
  world_.watch_events();
  recorder_.began({0, 0}, seed, nullptr, world_.scene());
  recorder_.saved({0, 0}, world_.state_hash(),
                  std::make_shared<const world::WorldState>(world_.save()));
}

void RecordedDemo::advance() {
  demo_.command();
  for (; told_ < demo_.commands().size(); ++told_) {
    const TimedCommand& timed = demo_.commands()[told_];
    api::Command command{.endpoint = 16, .body = {}};
    std::visit([&](const auto& body) { command.body = body; }, timed.command);
    recorder_.applied({0, timed.step}, {timed.ticket, std::move(command)}, nullptr);
  }
  world_.step();
  world_.events()->clear();
  const world::RunTime now{0, world_.step_count()};
  if (now.step % world::kSampleSteps == 0) recorder_.sampled(now, world::sample_of(world_));
  if (now.step % world::kCheckpointSteps == 0 || recorder_.wants_checkpoint()) {
    recorder_.saved(now, world_.state_hash(),
                    std::make_shared<const world::WorldState>(world_.save()));
  }
  demo_.observe();
}

}  // namespace aprsim::test
