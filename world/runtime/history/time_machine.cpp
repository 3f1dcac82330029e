#include "world/runtime/history/time_machine.hpp"

#include <cmath>
#include <exception>
#include <sys/resource.h>
#include <unistd.h>
#include <utility>

#include "world/cell/scene_editor.hpp"

namespace aprsim::world {
namespace {

/// Steps between cached states; a step back recomputes at most this many.
constexpr std::uint64_t kStateSteps = 200;
/// Niceness; the daemon's other threads have 0. On a busy machine this thread gets a tenth of their
/// share; at 19 queries of the past would starve.
constexpr int kNice = 10;

Error not_kept(api::Moment moment) {
  return {ErrorCode::kNotFound, "moment",
          "step " + std::to_string(moment.step) + " of epoch " + std::to_string(moment.epoch) +
              " is not kept"};
}

}  // namespace

TimeMachine::TimeMachine(std::shared_ptr<const scene::Scene> scene, HistoryRecords& records,
                         Bookmarks& bookmarks, const api::SnapshotSource* run,
                         std::uint64_t max_state_bytes)
    : scene_(std::move(scene)),
      records_(records),
      bookmarks_(bookmarks),
      run_(run),
      step_size_(std::llround(scene_->physics.step_s * 1e9)),
      states_(max_state_bytes) {
  thread_ = std::jthread([this](const std::stop_token& stop) { this->run(stop); });
}

TimeMachine::~TimeMachine() { stop(); }

void TimeMachine::stop() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  std::deque<Asked> left;
  {
    const std::lock_guard lock(mutex_);
    left.swap(asked_);
  }
  for (const Asked& asked : left) {
    asked.answer(fail(ErrorCode::kUnavailable, "history", "the daemon stops"));
  }
}

void TimeMachine::catch_up() const {
  if (run_ == nullptr) return;
  const api::SnapshotPtr now = run_->latest();
  records_.reach({now->epoch, now->step});
}

SimTime TimeMachine::time_of(std::uint64_t step) const {
  return step_size_ * static_cast<SimTime::rep>(step);
}

std::vector<api::HistorySpan> TimeMachine::spans() const {
  catch_up();
  auto spans = records_.spans();
  for (api::HistorySpan& span : spans) {
    span.first_time = time_of(span.first_step);
    span.last_time = time_of(span.last_step);
  }
  return spans;
}

void TimeMachine::ask(api::Moment moment, Answer answer) {
  catch_up();
  if (!records_.keeps(moment)) return answer(tl::unexpected(not_kept(moment)));
  {
    std::unique_lock lock(mutex_);
    if (ended_ || asked_.size() >= kMaxWaiting) {
      const char* why = ended_ ? "the daemon stops" : "too many moments are being computed";
      lock.unlock();
      return answer(fail(ErrorCode::kUnavailable, "history", why));
    }
    asked_.push_back({moment, std::move(answer)});
  }
  asked_for_.notify_one();
}

std::vector<api::Bookmark> TimeMachine::bookmarks() const {
  catch_up();  // the request may be for the present moment
  auto all = bookmarks_.all();
  std::erase_if(all, [this](const api::Bookmark& b) { return !records_.keeps(b.moment); });
  for (api::Bookmark& bookmark : all) bookmark.time = time_of(bookmark.moment.step);
  return all;
}

Result<api::Bookmark> TimeMachine::add_bookmark(api::Moment moment, std::string text) {
  catch_up();
  if (!records_.keeps(moment)) return tl::unexpected(not_kept(moment));
  auto bookmark = bookmarks_.add(moment, std::move(text));
  if (bookmark) bookmark->time = time_of(moment.step);
  return bookmark;
}

void TimeMachine::run(const std::stop_token& stop) {
  // Linux counts niceness by thread.
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kNice);
  while (true) {
    Asked next;
    {
      std::unique_lock lock(mutex_);
      if (!asked_for_.wait(lock, stop, [this] { return !asked_.empty(); })) return;
      next = std::move(asked_.front());
      asked_.pop_front();
    }
    Result<api::PastMoment> worked_out;
    try {
      worked_out = work_out(next.moment, stop);
    } catch (const std::exception& failure) {
      at_.reset();
      worked_out = fail(ErrorCode::kUnavailable, "history",
                        "the moment cannot be computed: " + std::string(failure.what()));
    }
    next.answer(std::move(worked_out));
  }
}

Result<api::PastMoment> TimeMachine::work_out(api::Moment moment, const std::stop_token& stop) {
  const auto course = records_.course_to(moment);
  if (!course) return tl::unexpected(not_kept(moment));
  if (!world_) {
    world_ = std::make_unique<World>(scene_, course->state->seed);
    // The state of the event detection is part of the world's state.
    world_->watch_events();
    at_.reset();
  }
  begin_at(*course, moment);
  auto command = course->commands.begin();
  while (command != course->commands.end() && (*command)->time.step < at_->step) ++command;
  while (at_->step < moment.step) {
    if (stop.stop_requested()) return fail(ErrorCode::kUnavailable, "history", "the daemon stops");
    for (; command != course->commands.end() && (*command)->time.step == at_->step; ++command) {
      // A command that failed in the run fails here, too.
      (void)apply_command(world_, (*command)->command.ticket, (*command)->command.command);
    }
    world_->step();
    world_->events()->clear();
    ++at_->step;
    if (at_->step % kStateSteps == 0) (void)keep_state();
  }
  auto snapshot = std::make_shared<api::Snapshot>();
  world_->write(*snapshot);
  snapshot->epoch = moment.epoch;
  snapshot->paused = true;
  return api::PastMoment{std::move(snapshot), keep_state()};
}

/// Begins at the latest of: the world's present moment, a state computed before, the recorded
/// state.
void TimeMachine::begin_at(const PastCourse& course, api::Moment moment) {
  const api::Moment recorded{course.begin.epoch, course.begin.step};
  const bool here = at_ && *at_ >= recorded && *at_ <= moment;
  const PastStates::Kept kept = states_.latest(here ? *at_ : recorded, moment);
  if (kept.state && !(here && kept.moment == *at_)) return put(kept.moment, *kept.state);
  if (!here) put(recorded, *course.state);
}

void TimeMachine::put(api::Moment moment, const WorldState& state) {
  at_.reset();
  if (state.scene && state.scene != world_->scene()) {
    world_ = std::make_unique<World>(state.scene, state.models, state.seed,
                                     std::span<robot::PlanPrefetcher* const>());
    world_->watch_events();
  }
  world_->restore(state);
  at_ = moment;
}

std::shared_ptr<const WorldState> TimeMachine::keep_state() {
  auto state = states_.find(*at_);
  if (state) return state;
  state = std::make_shared<const WorldState>(world_->save());
  states_.keep(*at_, state);
  return state;
}

}  // namespace aprsim::world
