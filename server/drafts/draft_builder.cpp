#include "server/drafts/draft_builder.hpp"

#include <exception>
#include <filesystem>
#include <sys/resource.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "server/drafts/tray_reach.hpp"
#include "world/base/yaml/yaml_tree.hpp"
#include "world/cell/world.hpp"
#include "world/devices/device_group.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server {
namespace {

/// Niceness of the thread; the daemon's other threads have 0.
constexpr int kDraftNice = 10;
constexpr std::size_t kMaxRobots = 16;  // of a draft; each reads a model

tl::unexpected<Error> unavailable(const char* why) {
  return fail(ErrorCode::kUnavailable, "draft", why);
}

}  // namespace

DraftBuilder::DraftBuilder(std::shared_ptr<const scene::Scene> scene)
    : scene_(std::move(scene)), sources_(scene_) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

DraftBuilder::~DraftBuilder() { stop(); }

web::SceneSource DraftBuilder::source_of(const api::CellDescription& cell) {
  const std::lock_guard lock(mutex_);
  return sources_.find(cell);
}

void DraftBuilder::build(std::string text, std::string name, Answer answer) {
  {
    std::unique_lock lock(mutex_);
    if (ended_ || waiting_.size() >= kMaxWaiting) {
      const char* const why = ended_ ? "the daemon ends" : "too many drafts wait; try again later";
      lock.unlock();
      return answer(unavailable(why));
    }
    waiting_.push_back({std::move(text), std::move(name), std::move(answer)});
  }
  wake_.notify_one();
}

void DraftBuilder::stop() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  std::deque<Request> waiting;
  {
    const std::lock_guard lock(mutex_);
    waiting.swap(waiting_);
  }
  for (const Request& request : waiting) request.answer(unavailable("the daemon ends"));
}

void DraftBuilder::run(const std::stop_token& stop) {
  // Linux counts niceness by thread.
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kDraftNice);
  while (true) {
    Request next;
    {
      std::unique_lock lock(mutex_);
      if (!wake_.wait(lock, stop, [this] { return !waiting_.empty(); }) || stop.stop_requested()) {
        return;
      }
      next = std::move(waiting_.front());
      waiting_.pop_front();
    }
    Result<web::SceneDraft> made = unavailable("the draft could not be built");
    try {
      made = make(next);
    } catch (const std::exception& failure) {
      made = fail(ErrorCode::kInvalidArgument, "scene", failure.what());
    }
    next.answer(std::move(made));
  }
}

Result<web::SceneDraft> DraftBuilder::make(const Request& request) {
  const std::string file =
      (std::filesystem::path(scene_->file).parent_path() / (request.name + ".yaml")).string();
  auto read =
      scene::read_sent(request.text, file, scene::default_data_paths(), scene::files_of(*scene_));
  if (!read) return tl::unexpected(std::move(read.error()));
  if (read->robots.size() > kMaxRobots) {
    return fail(ErrorCode::kInvalidArgument, "robots",
                "robots: found " + std::to_string(read->robots.size()) + ", expected at most " +
                    std::to_string(kMaxRobots) + " in a draft");
  }
  if (auto ok = devices::check_devices(*read, "scene text"); !ok) return tl::unexpected(ok.error());
  read->devices.clear();
  web::SceneDraft draft;
  for (const auto& robot : read->robots) {
    auto text = yaml::read_text(robot.model_file);
    if (!text) return tl::unexpected(std::move(text.error()));
    draft.models.push_back({robot.name, robot.model_file, *std::move(text)});
  }
  const auto scene = std::make_shared<const scene::Scene>(*std::move(read));
  const world::World world(scene, scene->seed);
  auto snapshot = std::make_shared<api::Snapshot>();
  world.write(*snapshot);
  snapshot->paused = true;
  draft.reaches = tray_reaches(world.models(), *snapshot);
  draft.snapshot = std::move(snapshot);
  const std::lock_guard lock(mutex_);
  sources_.keep(scene->text, request.text);
  return draft;
}

}  // namespace aprsim::server
