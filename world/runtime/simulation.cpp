#include "world/runtime/simulation.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <utility>

#include "world/cell/command_check.hpp"
#include "world/cell/next_scene.hpp"
#include "world/faults/fault_check.hpp"

namespace aprsim::world {
namespace {

using SteadyClock = std::chrono::steady_clock;

/// How long the thread sleeps at most while nothing is to be stepped.
constexpr std::chrono::milliseconds kIdle{20};

/// Steps between two looks at the command queue, while clients pace.
constexpr TimeBarrier::Steps kPacedBurst = 5;

/// A problem: no turn of the thread for so long; less than this share of the pace, or more than
/// this share of the queue full, at every turn for so long.
constexpr std::chrono::seconds kStuck{1}, kSlow{3}, kBacklog{1};
constexpr std::chrono::milliseconds kBacklogPause{200};
constexpr double kLeastPace = 0.9, kMostBacklog = 0.5;

std::int64_t now_ns() {
  return std::chrono::nanoseconds(SteadyClock::now().time_since_epoch()).count();
}

/// The command's Reset, if it names or carries another scene.
api::Reset* reset_to_other_scene(api::Command& command) {
  auto* simulation = std::get_if<api::SimulationCommand>(&command.body);
  auto* reset = simulation != nullptr ? std::get_if<api::Reset>(simulation) : nullptr;
  const bool has_scene =
      reset != nullptr && !(reset->scene_name.empty() && reset->scene_text.empty());
  return has_scene ? reset : nullptr;
}

std::vector<std::unique_ptr<robot::PlanningThread>> start_planning_threads(std::size_t count) {
  std::vector<std::unique_ptr<robot::PlanningThread>> threads(count);
  for (auto& thread : threads) thread = std::make_unique<robot::PlanningThread>();
  return threads;
}

std::vector<robot::PlanPrefetcher*> pointers(
    const std::vector<std::unique_ptr<robot::PlanningThread>>& threads) {
  std::vector<robot::PlanPrefetcher*> out;
  for (const auto& thread : threads) out.push_back(thread.get());
  return out;
}

}  // namespace

Simulation::Simulation(std::shared_ptr<const scene::Scene> scene, SimulationOptions options)
    : scene_at_start_(std::move(scene)),
      scene_(scene_at_start_),
      seed_(options.seed),
      queue_(options.queue_capacity),
      planning_threads_(start_planning_threads(scene_->robots.size())),
      prefetchers_(pointers(planning_threads_)),
      models_(load_models(*scene_)),
      world_(std::make_unique<World>(scene_, models_, seed_, prefetchers_)),
      pacer_(world_->step_size(), SteadyClock::now()),
      paused_(options.paused),
      saved_(options.max_saved_bytes),
      recorder_(options.recorder) {
  drained_.reserve(options.queue_capacity);
  if (options.virtual_time) {
    clock_ = std::make_unique<VirtualClock>(*std::move(options.virtual_time), world_->step_size(),
                                            [this] { queue_.notify(); });
    look_at_clock();
  }
  pacer_.set_speed(options.speed, SteadyClock::now());
  world_->watch_events();
  write_snapshot();
  record_epoch();
}

Simulation::~Simulation() { stop(); }

void Simulation::start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void Simulation::stop() {
  ending_ = true;
  thread_.request_stop();
  queue_.close();
  if (thread_.joinable()) thread_.join();
  last_turn_ns_ = 0;
  backlog_since_ns_ = 0;
}

Result<api::Ticket> Simulation::submit(api::Command command) {
  if (auto ok = check(command, *latest()->cell); !ok) return tl::unexpected(ok.error());
  if (api::Reset* reset = reset_to_other_scene(command)) {
    auto next = read_next_scene(*reset, *scene_at_start_);
    if (!next) return tl::unexpected(std::move(next.error()));
    reset->next = *std::move(next);
  }
  return queue_.push(std::move(command));
}

void Simulation::run(const std::stop_token& stop) {
  pacer_.restart(SteadyClock::now());
  while (!stop.stop_requested()) {
    const std::uint64_t seen = queue_.changes();
    look_at_clock();
    note_progress();
    // Commands take effect between steps, also while paused.
    if (may_drain()) drain();
    const bool stepping = world_fault_.empty() && (!paused_ || steps_wanted_ > 0);
    if (!stepping) {
      // Time that passes while paused or failed is not caught up with.
      const auto now = SteadyClock::now();
      pacer_.restart(now);
      pacer_.measure(now);
      if (dirty_) publish();
      if (recorder_ != nullptr && world_fault_.empty() && recorder_->wants_checkpoint()) {
        record_checkpoint();
      }
      if (clock_) clock_->release_clients(now);
      queue_.wait_until(seen, now + kIdle);
      continue;
    }
    int steps = steps_due();
    // Ahead of the clock: sleep until the next step or a command.
    if (steps == 0) {
      if (dirty_) publish();
      const auto now = SteadyClock::now();
      if (turn_.paced) pacer_.measure(now);
      queue_.wait_until(seen, turn_.paced ? now + kIdle : pacer_.next(now));
      continue;
    }
    // A short burst at the most, so that commands never wait for long.
    bool goes_on = true;
    for (; steps > 0 && goes_on && world_fault_.empty(); --steps) goes_on = advance();
  }
}

void Simulation::look_at_clock() {
  if (!clock_) return;
  const auto now = SteadyClock::now();
  const VirtualClock::Turn before = std::exchange(turn_, clock_->turn(now));
  if (turn_.state != before.state) dirty_ = true;
  // The wall clock does not catch up with what clients have paced.
  if (before.paced && !turn_.paced) pacer_.restart(now);
}

bool Simulation::may_drain() {
  if (!turn_.paced || turn_.due > 0 || paused_ || !world_fault_.empty()) return true;
  return queue_.holds_other_than(clock_->endpoints());
}

int Simulation::steps_due() {
  if (paused_) return 1;
  if (!turn_.paced) return pacer_.due(SteadyClock::now());
  return static_cast<int>(std::min(turn_.due, kPacedBurst));
}

void Simulation::note_progress() {
  const std::int64_t now = now_ns();
  last_turn_ns_ = now;
  const auto since = [now](std::atomic<std::int64_t>& begin, bool problem) {
    if (!problem) {
      begin = 0;
    } else if (begin == 0) {
      begin = now;
    }
  };
  // It is over when it has not been seen for a while: who floods may pause for a turn.
  if (queue_.size() > backlog_limit()) backlog_seen_ns_ = now;
  since(backlog_since_ns_,
        backlog_seen_ns_ != 0 &&
            now - backlog_seen_ns_ < std::chrono::nanoseconds(kBacklogPause).count());
  const double pace = pacer_.real_time_factor();
  const bool slow =
      !paused_ && !turn_.paced && pacer_.speed() && pace > 0 && pace < kLeastPace * *pacer_.speed();
  since(slow_since_ns_, slow);
}

std::size_t Simulation::backlog_limit() const {
  return static_cast<std::size_t>(kMostBacklog * static_cast<double>(queue_.capacity()));
}

bool Simulation::makes_progress() const {
  const std::int64_t turn = last_turn_ns_;
  return turn == 0 || now_ns() - turn <= std::chrono::nanoseconds(kStuck).count();
}

std::string Simulation::problem() const {
  const api::SnapshotPtr snapshot = latest();
  if (!snapshot->world_fault.empty()) {
    return "the simulation has stopped until the cell is reset: " + snapshot->world_fault;
  }
  const std::int64_t now = now_ns(), turn = last_turn_ns_, slow = slow_since_ns_,
                     backlog = backlog_since_ns_;
  char text[120];
  if (turn != 0 && now - turn > std::chrono::nanoseconds(kStuck).count()) {
    std::snprintf(text, sizeof text, "the simulation has not moved on for %.1f s",
                  static_cast<double>(now - turn) * 1e-9);
    return text;
  }
  if (backlog != 0 && now - backlog > std::chrono::nanoseconds(kBacklog).count()) {
    std::snprintf(text, sizeof text, "more than %zu commands wait at a time, for %.1f s",
                  backlog_limit(), static_cast<double>(now - backlog) * 1e-9);
    return text;
  }
  if (slow != 0 && now - slow > std::chrono::nanoseconds(kSlow).count()) {
    std::snprintf(text, sizeof text, "the pace is %.2f instead of %g", snapshot->real_time_factor,
                  snapshot->speed_target.value_or(0));
    return text;
  }
  return {};
}

void Simulation::drain() {
  queue_.drain(drained_);
  if (turn_.paced) {
    // Which of the clients that stand at this instant was quicker makes no difference.
    std::ranges::stable_sort(drained_, {},
                             [](const QueuedCommand& queued) { return queued.command.endpoint; });
  }
  for (const QueuedCommand& queued : drained_) {
    if (ending_) return;
    apply(queued);
    applied_ = std::max(applied_, queued.ticket);
    dirty_ = true;
  }
}

void Simulation::apply(const QueuedCommand& queued) {
  const RunTime before = run_time();
  // What begins a new epoch stands before it.
  const bool begins =
      std::holds_alternative<api::SimulationCommand>(queued.command.body) && recorder_ != nullptr;
  if (begins) recorder_->applied(before, queued, nullptr);
  const Result<void> done = carry_out(queued);
  if (!done) record_failure(queued.ticket, done.error());
  if (recorder_ != nullptr && !begins) {
    recorder_->applied(before, queued, done ? nullptr : &done.error());
  }
}

Result<void> Simulation::carry_out(const QueuedCommand& queued) {
  const auto* simulation = std::get_if<api::SimulationCommand>(&queued.command.body);
  try {
    if (simulation != nullptr) return apply(queued.ticket, *simulation);
    if (const auto* change = std::get_if<api::SceneCommand>(&queued.command.body)) {
      return edit(*change);
    }
    return world_->apply_any(queued.ticket, queued.command);
  } catch (const std::exception& failure) {
    const std::string why = "a command failed: " + std::string(failure.what());
    // Half a command may have been carried out.
    if (simulation == nullptr) stop_world(why);
    return fail(ErrorCode::kUnavailable, "simulation", why);
  }
}

Result<void> Simulation::apply(api::Ticket ticket, const api::SimulationCommand& command) {
  const auto now = SteadyClock::now();
  if (std::holds_alternative<api::Pause>(command)) {
    end_run(api::RunEnd::Why::kInterrupted, "the cell was paused");
    paused_ = true;
    paused_by_fault_ = false;
    steps_wanted_ = 0;
  } else if (std::holds_alternative<api::Resume>(command)) {
    paused_ = false;
    pacer_.restart(now);
  } else if (const auto* run = std::get_if<api::RunUntil>(&command)) {
    return run_until(ticket, *run);
  } else if (const auto* ending = std::get_if<api::EndRun>(&command)) {
    if (run_ && run_->ticket == ending->run) {
      end_run(api::RunEnd::Why::kInterrupted, "it was given up");
    }
  } else if (const auto* step = std::get_if<api::StepBy>(&command)) {
    end_run(api::RunEnd::Why::kInterrupted, "the cell was paused to be stepped");
    paused_ = true;
    steps_wanted_ += step->steps;
  } else if (const auto* speed = std::get_if<api::SetSpeed>(&command)) {
    pacer_.set_speed(speed->factor, now);
  } else if (const auto* again = std::get_if<api::Reset>(&command)) {
    return reset(*again);
  } else if (const auto* saving = std::get_if<api::SaveState>(&command)) {
    return save(*saving);
  } else if (const auto* loading = std::get_if<api::LoadState>(&command)) {
    return load(*loading);
  } else if (const auto* deleting = std::get_if<api::DeleteState>(&command)) {
    return saved_.forget(deleting->name);
  }
  return {};
}

Result<void> Simulation::run_until(api::Ticket ticket, const api::RunUntil& wanted) {
  if (!world_fault_.empty()) {
    return fail(ErrorCode::kFailedPrecondition, "simulation",
                "the cell has stopped until it is reset: " + world_fault_);
  }
  end_run(api::RunEnd::Why::kInterrupted, "another run has begun");
  Run run{ticket, wanted, world_->step_count() + wanted.steps};
  if (const auto* crossing = std::get_if<api::WhenCrossing>(&wanted.until)) {
    const auto robot = resolve(*crossing, *world_->description());
    if (!robot) return tl::unexpected(robot.error());
    run.robot = *robot;
  }
  run_ = std::move(run);
  number_events();
  hand_on_events();  // what has happened before is not what it waits for
  look_at_run();
  if (!run_) return {};
  paused_ = false;
  steps_wanted_ = 0;
  pacer_.restart(SteadyClock::now());
  return {};
}

void Simulation::look_at_run() {
  using Why = api::RunEnd::Why;
  const auto& until = run_->wanted.until;
  if (const auto* time = std::get_if<api::UntilTime>(&until)) {
    if (world_->time() >= time->time) return end_run(Why::kMet, "");
  } else if (const auto* crossing = std::get_if<api::WhenCrossing>(&until)) {
    if (world_->beyond(*crossing, run_->robot)) return end_run(Why::kMet, "");
  } else if (const auto* event = std::get_if<api::UntilEvent>(&until)) {
    number_events();
    const auto found = std::ranges::find_if(numbered_, [event](const api::CellEventPtr& one) {
      return api::is_wanted(*one, event->kinds, event->names);
    });
    if (found != numbered_.end()) return end_run(Why::kMet, "", (*found)->sequence);
  }
  if (world_->step_count() >= run_->last_step) end_run(Why::kSteps, "");
}

void Simulation::end_run(api::RunEnd::Why why, std::string text, std::uint64_t event) {
  if (!run_) return;
  std::vector<api::RunEnd> all;
  if (run_ends_) all = *run_ends_;
  if (all.size() >= api::kMaxRunEnds) all.erase(all.begin());
  all.push_back({run_->ticket, why, epoch_, world_->step_count(), event, std::move(text)});
  run_ends_ = std::make_shared<const std::vector<api::RunEnd>>(std::move(all));
  run_.reset();
  paused_ = true;
  steps_wanted_ = 0;
  dirty_ = true;
}

bool Simulation::advance() {
  const auto before = SteadyClock::now();
  try {
    world_->step();
  } catch (const std::exception& failure) {
    // The state of the last good step stays there to be looked at.
    stop_world(failure.what());
    return false;
  }
  if (paused_ && steps_wanted_ > 0) --steps_wanted_;
  const auto after = SteadyClock::now();
  pacer_.stepped(after, after - before);
  step_times_.add(after - before);
  solver_work_.set(world_->solver_work());
  record_step();
  if (clock_) clock_->stepped();
  if (run_) look_at_run();
  publish();
  return !clock_ || clock_->published(*slot_.latest(), after);
}

Result<void> Simulation::reset(const api::Reset& wanted) {
  number_events();
  const auto scene = wanted.next ? scene_of(*wanted.next) : scene_;
  // Another scene has a seed of its own.
  const std::uint64_t seed = wanted.seed.value_or(wanted.next ? scene->seed : seed_);
  // The old world goes when the new one is there.
  auto fresh = std::make_unique<World>(scene, models_, seed, prefetchers_);
  if (scene != world_->scene()) ++revision_;
  fresh->set_revision(revision_);
  fresh->watch_events();
  world_ = std::move(fresh);
  set_scene(scene);
  seed_ = seed;
  begin_epoch();
  return {};
}

std::shared_ptr<const scene::Scene> Simulation::scene() const {
  const std::lock_guard lock(scene_mutex_);
  return scene_;
}

void Simulation::set_scene(std::shared_ptr<const scene::Scene> scene) {
  // What it was before goes outside of the lock.
  const std::lock_guard lock(scene_mutex_);
  scene_.swap(scene);
}

Result<void> Simulation::edit(const api::SceneCommand& command) {
  const World* before = world_.get();
  if (auto done = World::edit(world_, command); !done) return done;
  if (world_.get() != before) world_->set_revision(++revision_);
  return {};
}

Result<void> Simulation::save(const api::SaveState& command) {
  auto state = command.state ? command.state : std::make_shared<const WorldState>(world_->save());
  return saved_.keep(command.name, std::move(state), world_->step_size());
}

Result<void> Simulation::load(const api::LoadState& command) {
  const api::StatePtr found = command.state ? command.state : saved_.find(command.name);
  if (found == nullptr) {
    return fail(ErrorCode::kNotFound, "name", "no state is saved as '" + command.name + "'");
  }
  auto loaded = std::make_shared<const std::string>(command.name);
  number_events();
  try {
    if (found->scene && found->scene != world_->scene()) {
      auto other = std::make_unique<World>(found->scene, models_, found->seed, prefetchers_);
      other->set_revision(++revision_);
      other->watch_events();
      world_ = std::move(other);
    }
    world_->restore(*found);
  } catch (const std::exception& failure) {
    stop_world("a saved state could not be restored: " + std::string(failure.what()));
    throw;
  }
  seed_ = found->seed;
  if (found->scene) set_scene(found->base_scene());
  begin_epoch(std::move(loaded));
  return {};
}

void Simulation::stop_world(const std::string& why) {
  end_run(api::RunEnd::Why::kInterrupted, "the world has stopped: " + why);
  world_fault_ = why;
  ++world_stops_;
  number_events();
  tell(api::CellEventKind::kWorldStopped, why);
  if (recorder_ != nullptr) recorder_->stopped(run_time(), why);
  paused_by_fault_ = !paused_;
  paused_ = true;
  dirty_ = true;
}

void Simulation::record_failure(api::Ticket ticket, Error error) {
  try {
    std::vector<api::CommandFailure> all;
    if (failures_) all = *failures_;
    if (all.size() >= api::kMaxFailures) all.erase(all.begin());
    all.push_back({ticket, std::move(error)});
    failures_ = std::make_shared<const std::vector<api::CommandFailure>>(std::move(all));
  } catch (const std::bad_alloc&) {
    // No memory to tell it: the command looks carried out, as far as its sender can see.
  }
}

void Simulation::begin_epoch(std::shared_ptr<const std::string> loaded) {
  end_run(api::RunEnd::Why::kInterrupted,
          loaded ? "a saved state was loaded" : "the cell was reset");
  ++epoch_;
  loaded_state_ = std::move(loaded);
  steps_wanted_ = 0;
  world_fault_.clear();
  if (std::exchange(paused_by_fault_, false)) paused_ = false;
  pacer_.restart(SteadyClock::now());
  record_epoch();
  tell(api::CellEventKind::kReset, loaded_state_ ? *loaded_state_ : "");
}

void Simulation::record_epoch() {
  if (recorder_ == nullptr) return;
  recorder_->began(run_time(), seed_, loaded_state_.get(), scene_);
  record_checkpoint();
}

void Simulation::record_step() {
  if (recorder_ == nullptr) return;
  const std::uint64_t step = world_->step_count();
  if (step % kSampleSteps == 0) {
    try {
      recorder_->sampled(run_time(), sample_of(*world_));
    } catch (const std::bad_alloc&) {
      // A run can be compared without one of them.
    }
  }
  if (step % kCheckpointSteps == 0 || recorder_->wants_checkpoint()) record_checkpoint();
}

void Simulation::record_checkpoint() {
  try {
    recorder_->saved(run_time(), world_->state_hash(),
                     std::make_shared<const WorldState>(world_->save()));
  } catch (const std::bad_alloc&) {
    // The next one may find memory again.
  }
}

void Simulation::tell(api::CellEventKind kind, std::string text) {
  auto* found = world_->events();
  found->push_back({.step = world_->step_count(),
                    .time = world_->time(),
                    .kind = kind,
                    .text = std::move(text)});
}

void Simulation::number_events() {
  auto& found = *world_->events();
  std::size_t done = 0;
  try {
    numbered_.reserve(numbered_.size() + found.size());
    for (; done < found.size(); ++done) {
      auto event = std::make_shared<api::CellEvent>(std::move(found[done]));
      event->sequence = ++last_event_;
      event->epoch = epoch_;
      numbered_.push_back(std::move(event));
      if (recorder_ != nullptr) recorder_->happened(numbered_.back());
    }
  } catch (const std::bad_alloc&) {
    // The others when there is memory again.
  }
  found.erase(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(done));
}

void Simulation::hand_on_events() {
  if (numbered_.empty()) return;
  events_.add(std::exchange(numbered_, {}));
}

void Simulation::publish() {
  try {
    number_events();
    hand_on_events();
    write_snapshot();
    followers_.publish(slot_.latest());
    dirty_ = false;
  } catch (const std::bad_alloc&) {
    dirty_ = true;  // the next one may find memory again
  }
}

void Simulation::write_snapshot() {
  auto snapshot = slot_.acquire();
  world_->write(*snapshot);
  snapshot->epoch = epoch_;
  snapshot->loaded_state = loaded_state_;
  snapshot->applied = applied_;
  snapshot->failures = failures_;
  snapshot->paused = paused_;
  snapshot->speed_target = turn_.paced ? std::nullopt : pacer_.speed();
  snapshot->virtual_time = turn_.state;
  snapshot->real_time_factor = pacer_.real_time_factor();
  snapshot->missed_steps = pacer_.missed_steps();
  snapshot->step_time_s = pacer_.step_time_s();
  snapshot->plan_waits = world_->plan_waits();
  snapshot->saved_states = saved_.list();
  snapshot->world_fault = world_fault_;
  snapshot->world_stops = world_stops_;
  snapshot->last_event = last_event_;
  snapshot->runs = run_ends_;
  slot_.publish(std::move(snapshot));
}

}  // namespace aprsim::world
