#include "world/runtime/preview/move_previewer.hpp"

#include <exception>
#include <sys/resource.h>
#include <unistd.h>
#include <utility>

namespace aprsim::world {
namespace {

/// Niceness of the thread; the daemon's other threads have 0.
constexpr int kPreviewNice = 10;
const char* const kEnds = "the simulation ends";

tl::unexpected<Error> unavailable(const char* why) {
  return fail(ErrorCode::kUnavailable, "preview", why);
}

}  // namespace

// ---- one preview

BoundPreview::BoundPreview(const World& world, std::uint64_t epoch,
                           const api::PreviewRequest& request)
    : moment_{.epoch = epoch, .step = world.step_count(), .time = world.time()},
      move_(world.preview(request.command, request.mode)) {
  const auto robot = static_cast<std::size_t>(request.command.robot);
  moment_.mode = request.mode.value_or(world.robots()[robot].planning());
}

Result<api::MovePreview> BoundPreview::make() {
  if (!move_) {
    if (move_.error().code != ErrorCode::kFailedPrecondition) {
      return tl::unexpected(move_.error());
    }
    moment_.refusal = move_.error().message;
    return moment_;
  }
  auto made = (*move_)->make();
  if (!made) return made;
  made->epoch = moment_.epoch;
  made->step = moment_.step;
  made->time = moment_.time;
  return made;
}

// ---- the thread

MovePreviewer::MovePreviewer(Simulation simulation) : simulation_(std::move(simulation)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

MovePreviewer::~MovePreviewer() { stop(); }

void MovePreviewer::ask(api::PreviewRequest request, Answer answer) {
  api::Command command{.body = request.command};
  if (auto ok = simulation_.check(command); !ok) return answer(tl::unexpected(ok.error()));
  {
    std::unique_lock lock(mutex_);
    if (ended_ || asked_.size() + bound_.size() >= kMaxWaiting) {
      const char* const why =
          ended_ ? kEnds : "too many previews are being planned; try again later";
      lock.unlock();
      return answer(unavailable(why));
    }
    asked_.push_back({std::move(request), std::move(answer)});
    requests_.store(asked_.size(), std::memory_order_release);
  }
  simulation_.notify();
}

void MovePreviewer::bind_next(const World& world, std::uint64_t epoch) {
  Asked next;
  {
    const std::lock_guard lock(mutex_);
    if (asked_.empty()) return;
    next = std::move(asked_.front());
    asked_.pop_front();
    requests_.store(asked_.size(), std::memory_order_release);
  }
  Bound bound{nullptr, std::move(next.answer)};
  try {
    bound.preview = std::make_shared<BoundPreview>(world, epoch, next.request);
  } catch (const std::exception&) {
    // The simulation goes on without it.
  }
  bool ended = false;
  {
    const std::lock_guard lock(mutex_);
    ended = ended_;
    if (!ended) bound_.push_back(std::move(bound));
  }
  if (ended) return bound.answer(unavailable(kEnds));
  bound_one_.notify_one();
}

void MovePreviewer::run(const std::stop_token& stop) {
  // Linux counts niceness by thread.
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kPreviewNice);
  while (true) {
    Bound next;
    {
      std::unique_lock lock(mutex_);
      running_ = nullptr;
      if (!bound_one_.wait(lock, stop, [this] { return !bound_.empty(); })) return;
      next = std::move(bound_.front());
      bound_.pop_front();
      running_ = next.preview;
    }
    Result<api::MovePreview> made = unavailable("the move could not be planned");
    try {
      if (next.preview) made = next.preview->make();
    } catch (const std::exception&) {
      // Out of memory: this preview is lost.
    }
    next.answer(std::move(made));
  }
}

void MovePreviewer::stop() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    if (running_) running_->cancel();
  }
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  std::deque<Asked> asked;
  std::deque<Bound> bound;
  {
    const std::lock_guard lock(mutex_);
    asked.swap(asked_);
    bound.swap(bound_);
    requests_ = 0;
  }
  for (const Asked& each : asked) each.answer(unavailable(kEnds));
  for (const Bound& each : bound) each.answer(unavailable(kEnds));
}

}  // namespace aprsim::world
