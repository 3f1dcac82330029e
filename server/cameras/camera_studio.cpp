#include "server/cameras/camera_studio.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "server/cameras/picture_encoder.hpp"
#include "world/render/cell/cell_model.hpp"
#include "world/render/renderer.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server {
namespace {

using Clock = std::chrono::steady_clock;
using protocols::CameraPicture;
using protocols::PictureForm;

constexpr int kNice = 10;  // below all other threads
constexpr std::chrono::seconds kIdle{60};

tl::unexpected<Error> unavailable(const std::string& why) {
  return fail(ErrorCode::kUnavailable, "camera", why);
}

protocols::CameraInfo info_of(const scene::Camera& camera, const scene::Scene& scene) {
  const scene::Lens& lens = camera.lens;
  return {.name = camera.name,
          .robot = camera.robot < 0 ? std::string()
                                    : scene.robots.at(static_cast<std::size_t>(camera.robot)).name,
          .width = lens.width_px,
          .height = lens.height_px,
          .rate_hz = camera.rate_hz,
          .latency_s = camera.latency_s,
          .X_WC = camera.X_WC,
          .focal_px = {lens.focal_px.x(), lens.focal_px.y()},
          .centre_px = {lens.centre_px.x(), lens.centre_px.y()},
          .distortion = lens.distortion};
}

std::shared_ptr<const std::vector<protocols::PictureObject>> objects_of(
    const render::CellModel& model) {
  using Kind = protocols::PictureObject::Kind;
  std::vector<protocols::PictureObject> out;
  for (const render::SceneObject& object : model.objects()) {
    // The kinds are in the same order.
    static_assert(static_cast<int>(render::SceneObject::Kind::kIntruder) ==
                  static_cast<int>(Kind::kIntruder));
    out.push_back({static_cast<Kind>(object.kind), object.name});
  }
  return std::make_shared<const std::vector<protocols::PictureObject>>(std::move(out));
}

}  // namespace

class CameraStudio::Impl {
 public:
  Impl(std::shared_ptr<const scene::Scene> scene, const api::SnapshotSource& source,
       StudioOptions options)
      : scene_(std::move(scene)),
        source_(source),
        options_(options),
        rooms_(scene_->cameras.size()) {
    for (const scene::Camera& camera : scene_->cameras) {
      infos_.push_back(info_of(camera, *scene_));
    }
    if (!infos_.empty()) thread_ = std::thread([this] { run(); });
  }

  ~Impl() { stop(); }

  [[nodiscard]] const std::vector<protocols::CameraInfo>& cameras() const { return infos_; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

  void take_picture(std::size_t camera, PictureForm form, Done done) {
    {
      const std::lock_guard lock(mutex_);
      if (!stopping_) {
        requests_.push_back({camera, form, std::move(done)});
        asked_.notify_one();
        return;
      }
    }
    done(unavailable("the daemon is stopping"));
  }

  void stop() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
      asked_.notify_one();
    }
    if (thread_.joinable()) thread_.join();
  }

 private:
  struct Request {
    std::size_t camera = 0;
    PictureForm form = PictureForm::kJpeg;
    Done done;
  };
  /// A camera in use.
  struct Room {
    std::unique_ptr<render::Renderer> renderer;
    Clock::time_point used{};
    CameraPicture drawn;  // without bytes
    bool is_drawn = false;
    std::map<PictureForm, std::shared_ptr<const std::string>> bytes;  // of what is drawn
  };

  void run() {
    // Linux has a priority for each thread.
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
    while (true) {
      std::vector<Request> requests;
      bool stopping = false;
      {
        std::unique_lock lock(mutex_);
        asked_.wait_for(lock, kIdle, [this] { return stopping_ || !requests_.empty(); });
        requests.swap(requests_);
        stopping = stopping_;
      }
      for (Request& request : requests) {
        request.done(stopping ? unavailable("the daemon is stopping") : picture_of(request));
      }
      if (stopping) return;
      free_idle();
      bytes_ = used_bytes();
    }
  }

  Result<CameraPicture> picture_of(const Request& request) {
    try {
      const api::SnapshotPtr snapshot = source_.latest();
      if (auto ready = prepare(*snapshot); !ready) return tl::unexpected(ready.error());
      if (auto place = make_place(request.camera); !place) return tl::unexpected(place.error());
      Room& room = rooms_.at(request.camera);
      draw(room, request.camera, *snapshot);
      auto& bytes = room.bytes[request.form];
      if (!bytes) {
        auto made = encoder_.encode(*room.renderer, *model_, request.form);
        if (!made) return tl::unexpected(made.error());
        bytes = std::make_shared<const std::string>(*std::move(made));
      }
      CameraPicture out = room.drawn;
      out.bytes = bytes;
      return out;
    } catch (const std::exception& problem) {
      return unavailable(std::string("the cell cannot be rendered: ") + problem.what());
    }
  }

  /// Makes the model of the snapshot's cell, anew where its scene has changed.
  Result<void> prepare(const api::Snapshot& snapshot) {
    if (model_ && cell_ == snapshot.cell) return {};
    for (Room& room : rooms_) room = {};
    model_.reset();
    const api::CellDescription& cell = *snapshot.cell;
    Result<render::CellModel> model = unavailable("");
    if (!cell.scene_text || *cell.scene_text == scene_->text) {
      model = render::CellModel::make(*scene_, cell);
    } else {
      const auto file = std::filesystem::path(scene_->file).parent_path() / (cell.scene + ".yaml");
      const auto other =
          scene::read_edited(*cell.scene_text, file.string(), scene::default_data_paths());
      if (!other) return tl::unexpected(other.error());
      model = render::CellModel::make(*other, cell);
    }
    if (!model) return tl::unexpected(model.error());
    model_.emplace(*std::move(model));
    objects_ = objects_of(*model_);
    cell_ = snapshot.cell;
    return {};
  }

  /// Frees the renderers that were used least recently, as far as another one needs their memory.
  Result<void> make_place(std::size_t camera) {
    if (rooms_[camera].renderer) return {};
    const std::uint64_t needed = render::Renderer::needed_bytes(scene_->cameras[camera]);
    if (needed > options_.max_bytes) {
      return fail(ErrorCode::kFailedPrecondition, "cameras.max_mb",
                  fmt::format("{} MB are too few for {}, which needs {}", options_.max_bytes >> 20U,
                              infos_[camera].name, (needed >> 20U) + 1));
    }
    while (used_bytes() + needed > options_.max_bytes) {
      *std::ranges::min_element(rooms_, {}, [](const Room& room) {
        return room.renderer ? room.used : Clock::time_point::max();
      }) = {};
    }
    return {};
  }

  [[nodiscard]] std::uint64_t used_bytes() const {
    std::uint64_t sum = 0;
    for (const Room& room : rooms_) {
      if (room.renderer) sum += render::Renderer::needed_bytes(room.renderer->camera());
    }
    return sum;
  }

  void draw(Room& room, std::size_t camera, const api::Snapshot& snapshot) {
    room.used = Clock::now();
    if (!room.renderer) {
      room.renderer = std::make_unique<render::Renderer>(
          scene_->cameras.at(camera), render::lamps_over(model_->extent()), options_.seed + camera);
    }
    // A paused cell may change within its step; what did not costs next to nothing.
    const bool noisy = room.renderer->camera().noise > 0 && room.drawn.step != snapshot.step;
    const std::size_t tiles = room.renderer->draw(model_->place(snapshot), snapshot.step);
    if (tiles > 0 || noisy || !room.is_drawn) room.bytes.clear();
    const scene::Lens& lens = room.renderer->camera().lens;
    room.drawn = {snapshot.epoch, snapshot.step, snapshot.time, lens.width_px, lens.height_px, {},
                  objects_};
    room.is_drawn = true;
  }

  void free_idle() {
    const auto now = Clock::now();
    for (Room& room : rooms_) {
      if (room.renderer && now - room.used >= kIdle) room = {};
    }
  }

  const std::shared_ptr<const scene::Scene> scene_;
  const api::SnapshotSource& source_;
  const StudioOptions options_;
  std::vector<protocols::CameraInfo> infos_;

  std::mutex mutex_;
  std::condition_variable asked_;
  std::vector<Request> requests_;
  bool stopping_ = false;
  std::atomic<std::uint64_t> bytes_{0};

  // For the studio's thread alone.
  std::shared_ptr<const api::CellDescription> cell_;  // of the model
  std::optional<render::CellModel> model_;
  std::shared_ptr<const std::vector<protocols::PictureObject>> objects_;  // of the model
  std::vector<Room> rooms_;
  PictureEncoder encoder_;

  std::thread thread_;
};

CameraStudio::CameraStudio(std::shared_ptr<const scene::Scene> scene,
                           const api::SnapshotSource& source, StudioOptions options)
    : impl_(std::make_unique<Impl>(std::move(scene), source, options)) {}

CameraStudio::~CameraStudio() = default;

const std::vector<protocols::CameraInfo>& CameraStudio::cameras() const { return impl_->cameras(); }

void CameraStudio::take_picture(std::size_t camera, PictureForm form, Done done) {
  impl_->take_picture(camera, form, std::move(done));
}

std::uint64_t CameraStudio::bytes() const { return impl_->bytes(); }

void CameraStudio::stop() { impl_->stop(); }

}  // namespace aprsim::server
