#include "world/simulation.hpp"

#include <exception>
#include <utility>

#include "world/command_check.hpp"

namespace aprsim::world {
namespace {

using SteadyClock = std::chrono::steady_clock;

/// How long the thread sleeps at most while nothing is to be stepped.
constexpr std::chrono::milliseconds kIdle{20};

}  // namespace

Simulation::Simulation(std::shared_ptr<const scene::Scene> scene, SimulationOptions options)
    : scene_(std::move(scene)),
      seed_(options.seed),
      queue_(options.queue_capacity),
      world_(std::in_place, scene_, seed_),
      pacer_(world_->step_size(), SteadyClock::now()),
      description_(world_->description()),
      paused_(options.paused) {
  drained_.reserve(options.queue_capacity);
  pacer_.set_speed(options.speed, SteadyClock::now());
  publish();
}

Simulation::~Simulation() { stop(); }

void Simulation::start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void Simulation::stop() {
  thread_.request_stop();
  queue_.close();
  if (thread_.joinable()) thread_.join();
}

Result<api::Ticket> Simulation::submit(api::Command command) {
  // Robots, joints and belt are the same after a reset, so the first description serves.
  if (auto ok = check(command, *description_); !ok) return tl::unexpected(ok.error());
  return queue_.push(std::move(command));
}

void Simulation::run(const std::stop_token& stop) {
  pacer_.restart(SteadyClock::now());
  while (!stop.stop_requested()) {
    // Commands take effect between steps, also while paused.
    drain();
    const bool stepping = world_fault_.empty() && (!paused_ || steps_wanted_ > 0);
    if (!stepping) {
      // Time that passes while paused or failed is not caught up with.
      const auto now = SteadyClock::now();
      pacer_.restart(now);
      pacer_.measure(now);
      if (dirty_) publish();
      queue_.wait_until(now + kIdle);
      continue;
    }
    int steps = paused_ ? 1 : pacer_.due(SteadyClock::now());
    // Ahead of the clock: sleep until the next step or a command.
    if (steps == 0) {
      if (dirty_) publish();
      queue_.wait_until(pacer_.next(SteadyClock::now()));
      continue;
    }
    // A short burst at the most, so that commands never wait for long.
    for (; steps > 0 && world_fault_.empty(); --steps) advance();
  }
}

void Simulation::drain() {
  queue_.drain(drained_);
  for (const auto& [ticket, command] : drained_) {
    std::visit(
        [&, id = ticket](const auto& body) {
          if constexpr (std::is_same_v<std::decay_t<decltype(body)>, api::SimulationCommand>) {
            apply(body);
          } else {
            world_->apply(id, body);
          }
        },
        command.body);
    applied_ = ticket;
    dirty_ = true;
  }
}

void Simulation::apply(const api::SimulationCommand& command) {
  const auto now = SteadyClock::now();
  if (std::holds_alternative<api::Pause>(command)) {
    paused_ = true;
    paused_by_fault_ = false;
    steps_wanted_ = 0;
  } else if (std::holds_alternative<api::Resume>(command)) {
    paused_ = false;
    pacer_.restart(now);
  } else if (const auto* step = std::get_if<api::StepBy>(&command)) {
    paused_ = true;
    steps_wanted_ += step->steps;
  } else if (const auto* speed = std::get_if<api::SetSpeed>(&command)) {
    pacer_.set_speed(speed->factor, now);
  } else if (const auto* again = std::get_if<api::Reset>(&command)) {
    reset(again->seed);
  } else if (const auto* saving = std::get_if<api::SaveState>(&command)) {
    save(saving->name);
  } else if (const auto* loading = std::get_if<api::LoadState>(&command)) {
    load(loading->name);
  }
}

void Simulation::advance() {
  const auto before = SteadyClock::now();
  try {
    world_->step();
  } catch (const std::exception& failure) {
    // The state of the last good step stays there to be looked at until a reset or a load.
    world_fault_ = failure.what();
    paused_by_fault_ = !paused_;
    paused_ = true;
    dirty_ = true;
    return;
  }
  if (paused_ && steps_wanted_ > 0) --steps_wanted_;
  const auto after = SteadyClock::now();
  pacer_.stepped(after, after - before);
  publish();
}

void Simulation::reset(std::optional<std::uint64_t> seed) {
  if (seed) seed_ = *seed;
  // The old world goes first: one physics world at a time keeps ODE's globals out of the question.
  world_.reset();
  world_.emplace(scene_, seed_);
  begin_epoch();
}

void Simulation::save(const std::string& name) {
  if (!saved_.contains(name) && saved_.size() >= api::kMaxSavedStates) return;
  saved_.insert_or_assign(name, world_->save());
  std::vector<std::string> names;
  for (const auto& [saved, state] : saved_) names.push_back(saved);
  saved_names_ = std::make_shared<const std::vector<std::string>>(std::move(names));
}

void Simulation::load(const std::string& name) {
  const auto found = saved_.find(name);
  if (found == saved_.end()) return;
  world_->restore(found->second);
  seed_ = found->second.seed;
  begin_epoch();
}

void Simulation::begin_epoch() {
  ++epoch_;
  steps_wanted_ = 0;
  world_fault_.clear();
  if (std::exchange(paused_by_fault_, false)) paused_ = false;
  pacer_.restart(SteadyClock::now());
}

void Simulation::publish() {
  auto snapshot = slot_.acquire();
  world_->write(*snapshot);
  snapshot->epoch = epoch_;
  snapshot->applied = applied_;
  snapshot->paused = paused_;
  snapshot->speed_target = pacer_.speed();
  snapshot->real_time_factor = pacer_.real_time_factor();
  snapshot->missed_steps = pacer_.missed_steps();
  snapshot->step_time_s = pacer_.step_time_s();
  snapshot->saved_states = saved_names_;
  snapshot->world_fault = world_fault_;
  slot_.publish(std::move(snapshot));
  dirty_ = false;
}

}  // namespace aprsim::world
