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
#include <string>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "server/cameras/picture_encoder.hpp"
#include "world/render/camera_faults.hpp"
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
constexpr const char* kMemoryKey = "cameras.max_mb";

tl::unexpected<Error> unavailable(const std::string& why) {
  return fail(ErrorCode::kUnavailable, "camera", why);
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
      : source_(source), options_(options), scene_(std::move(scene)) {
    thread_ = std::thread([this] { run(); });
  }

  ~Impl() { stop(); }

  [[nodiscard]] std::shared_ptr<const protocols::CameraList> cameras() const {
    const auto cell = source_.latest()->cell;
    return {cell, &cell->cameras};
  }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

  void take_picture(const std::string& camera, PictureForm form, Done done) {
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
    std::string camera;
    PictureForm form = PictureForm::kJpeg;
    Done done;
  };
  /// A camera in use.
  struct Room {
    std::unique_ptr<render::Renderer> renderer;
    Clock::time_point used{};
    CameraPicture drawn;  // without bytes
    bool is_drawn = false;
    int jpeg_quality = 0;                                             // of the bytes
    std::map<PictureForm, std::shared_ptr<const std::string>> bytes;  // of what is drawn

    [[nodiscard]] std::uint64_t memory() const {
      std::uint64_t sum = renderer ? renderer->bytes() : 0;
      for (const auto& [form, picture] : bytes) sum += picture->capacity();
      return sum;
    }
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
      const auto found = std::ranges::find(scene_->cameras, request.camera, &scene::Camera::name);
      if (found == scene_->cameras.end()) {
        return fail(ErrorCode::kNotFound, "camera",
                    fmt::format("scene {} has no camera '{}'", scene_->name, request.camera));
      }
      const auto camera = render::with_faults(*found, snapshot->faults.get());
      if (!camera) return unavailable(request.camera + " is out of order");
      auto picture = picture_of(request, *camera, *snapshot);
      // Where others have the memory, they give it back.
      if (!picture && picture.error().field == kMemoryKey && rooms_.size() > 1) {
        rooms_.clear();
        picture = picture_of(request, *camera, *snapshot);
      }
      if (!picture && picture.error().field == kMemoryKey) rooms_.erase(request.camera);
      return picture;
    } catch (const std::exception& problem) {
      rooms_.erase(request.camera);
      return unavailable(std::string("the cell cannot be rendered: ") + problem.what());
    }
  }

  Result<CameraPicture> picture_of(const Request& request, const scene::Camera& camera,
                                   const api::Snapshot& snapshot) {
    Room& room = rooms_[request.camera];
    if (auto place = make_place(room, camera); !place) return tl::unexpected(place.error());
    if (auto drawn = draw(room, camera, snapshot); !drawn) return tl::unexpected(drawn.error());
    auto& bytes = room.bytes[request.form];
    if (!bytes) {
      bytes = std::make_shared<const std::string>();
      const std::uint64_t needed = PictureEncoder::most_bytes(camera.lens, request.form);
      auto made = used_bytes() + needed > options_.max_bytes
                      ? too_little(camera, used_bytes() + needed)
                      : encoder_.encode(*room.renderer, *model_, request.form, camera.jpeg_quality);
      if (!made) {
        room.bytes.erase(request.form);
        return tl::unexpected(made.error());
      }
      bytes = std::make_shared<const std::string>(*std::move(made));
    }
    CameraPicture out = room.drawn;
    out.bytes = bytes;
    return out;
  }

  /// Makes the model of the snapshot's cell, anew where its scene has changed.
  Result<void> prepare(const api::Snapshot& snapshot) {
    if (model_ && cell_ == snapshot.cell) return {};
    rooms_.clear();
    model_.reset();
    const api::CellDescription& cell = *snapshot.cell;
    if (cell.scene_text && *cell.scene_text != scene_->text) {
      const auto file = std::filesystem::path(scene_->file).parent_path() / (cell.scene + ".yaml");
      auto other = scene::read_edited(*cell.scene_text, file.string(), scene::default_data_paths());
      if (!other) return tl::unexpected(other.error());
      scene_ = std::make_shared<const scene::Scene>(*std::move(other));
    }
    auto model = render::CellModel::make(*scene_, cell);
    if (!model) return tl::unexpected(model.error());
    model_.emplace(*std::move(model));
    objects_ = objects_of(*model_);
    cell_ = snapshot.cell;
    return {};
  }

  [[nodiscard]] tl::unexpected<Error> too_little(const scene::Camera& camera,
                                                 std::uint64_t needed) const {
    return fail(ErrorCode::kFailedPrecondition, kMemoryKey,
                fmt::format("{} MB are too few for the pictures of {}, which need {} or more",
                            options_.max_bytes >> 20U, camera.name, (needed >> 20U) + 1));
  }

  /// Frees the renderers that were used least recently, as far as another one needs their memory.
  Result<void> make_place(Room& room, const scene::Camera& camera) {
    if (room.renderer) return {};
    const std::uint64_t needed = render::Renderer::fixed_bytes(camera);
    if (model_->bytes() + needed > options_.max_bytes) {
      return too_little(camera, model_->bytes() + needed);
    }
    while (used_bytes() + needed > options_.max_bytes) {
      std::ranges::min_element(rooms_, {}, [](const auto& other) {
        return other.second.renderer ? other.second.used : Clock::time_point::max();
      })->second = {};
    }
    return {};
  }

  [[nodiscard]] std::uint64_t used_bytes() const {
    std::uint64_t sum = model_ ? model_->bytes() : 0;
    for (const auto& [name, room] : rooms_) sum += room.memory();
    return sum;
  }

  Result<void> draw(Room& room, const scene::Camera& camera, const api::Snapshot& snapshot) {
    room.used = Clock::now();
    if (!room.renderer) {
      room.renderer = std::make_unique<render::Renderer>(
          camera, render::lamps_over(model_->extent()), seed_of(camera), model_->extent());
    }
    render::Renderer& renderer = *room.renderer;
    renderer.set_limit(options_.max_bytes -
                       std::min(options_.max_bytes, used_bytes() - renderer.bytes()));
    const auto& placements = model_->place(snapshot);
    const Pose X_WC = model_->X_WC(camera);
    // A paused cell may change within its step; what did not costs next to nothing.
    const bool noisy = camera.noise > 0 && room.drawn.step != snapshot.step;
    const bool other = renderer.set_camera(camera, X_WC.isometry(), seconds(snapshot.time));
    const auto tiles = renderer.draw(placements, snapshot.step);
    if (!tiles) {
      const std::uint64_t needed = used_bytes();
      return too_little(camera, std::max(needed, options_.max_bytes));
    }
    if (*tiles > 0 || noisy || other || !room.is_drawn) room.bytes.clear();
    if (room.jpeg_quality != camera.jpeg_quality) room.bytes.erase(PictureForm::kJpeg);
    room.jpeg_quality = camera.jpeg_quality;
    room.drawn = {.epoch = snapshot.epoch,
                  .step = snapshot.step,
                  .time = snapshot.time,
                  .width = camera.lens.width_px,
                  .height = camera.lens.height_px,
                  .X_WC = X_WC,
                  .rate_hz = camera.rate_hz,
                  .latency_s = camera.latency_s,
                  .bytes = {},
                  .objects = objects_};
    room.is_drawn = true;
    return {};
  }

  /// Cameras side by side have different noise.
  [[nodiscard]] std::uint64_t seed_of(const scene::Camera& camera) const {
    const auto place = std::ranges::find(scene_->cameras, camera.name, &scene::Camera::name);
    return options_.seed + static_cast<std::uint64_t>(place - scene_->cameras.begin());
  }

  void free_idle() {
    const auto now = Clock::now();
    std::erase_if(rooms_, [now](const auto& room) { return now - room.second.used >= kIdle; });
  }

  const api::SnapshotSource& source_;
  const StudioOptions options_;

  std::mutex mutex_;
  std::condition_variable asked_;
  std::vector<Request> requests_;
  bool stopping_ = false;
  std::atomic<std::uint64_t> bytes_{0};

  // For the studio's thread alone.
  std::shared_ptr<const scene::Scene> scene_;         // of the model, or that of the start
  std::shared_ptr<const api::CellDescription> cell_;  // of the model
  std::optional<render::CellModel> model_;
  std::shared_ptr<const std::vector<protocols::PictureObject>> objects_;  // of the model
  std::map<std::string, Room> rooms_;                                     // by camera
  PictureEncoder encoder_;

  std::thread thread_;
};

CameraStudio::CameraStudio(std::shared_ptr<const scene::Scene> scene,
                           const api::SnapshotSource& source, StudioOptions options)
    : impl_(std::make_unique<Impl>(std::move(scene), source, options)) {}

CameraStudio::~CameraStudio() = default;

std::shared_ptr<const protocols::CameraList> CameraStudio::cameras() const {
  return impl_->cameras();
}

void CameraStudio::take_picture(const std::string& camera, PictureForm form, Done done) {
  impl_->take_picture(camera, form, std::move(done));
}

std::uint64_t CameraStudio::bytes() const { return impl_->bytes(); }

void CameraStudio::stop() { impl_->stop(); }

}  // namespace aprsim::server
