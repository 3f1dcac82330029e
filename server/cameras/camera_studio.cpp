#include "server/cameras/camera_studio.hpp"

#include <chrono>
#include <condition_variable>
#include <cstring>
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

#include <spdlog/spdlog.h>

#include "server/cameras/jpeg.hpp"
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

/// The bytes of values in this machine's order, which is little-endian.
template <typename T>
std::string bytes_of(const render::Picture<T>& picture) {
  std::string out(picture.values.size() * sizeof(T), '\0');
  std::memcpy(out.data(), picture.values.data(), out.size());
  return out;
}

tl::unexpected<Error> unavailable(const std::string& why) {
  return fail(ErrorCode::kUnavailable, "camera", why);
}

}  // namespace

class CameraStudio::Impl {
 public:
  Impl(std::shared_ptr<const scene::Scene> scene, const api::SnapshotSource& source,
       std::uint64_t seed)
      : scene_(std::move(scene)), source_(source), seed_(seed), rooms_(scene_->cameras.size()) {
    for (const scene::Camera& camera : scene_->cameras) {
      infos_.push_back({camera.name, camera.lens.width_px, camera.lens.height_px, camera.rate_hz,
                        camera.latency_s});
    }
    if (!infos_.empty()) thread_ = std::thread([this] { run(); });
  }

  ~Impl() { stop(); }

  [[nodiscard]] const std::vector<protocols::CameraInfo>& cameras() const { return infos_; }

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
    }
  }

  Result<CameraPicture> picture_of(const Request& request) {
    try {
      const api::SnapshotPtr snapshot = source_.latest();
      if (auto ready = prepare(*snapshot); !ready) return tl::unexpected(ready.error());
      Room& room = rooms_.at(request.camera);
      draw(room, request.camera, *snapshot);
      auto& bytes = room.bytes[request.form];
      if (!bytes) {
        auto made = encode(*room.renderer, request.form);
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
    cell_ = snapshot.cell;
    return {};
  }

  void draw(Room& room, std::size_t camera, const api::Snapshot& snapshot) {
    room.used = Clock::now();
    if (!room.renderer) {
      room.renderer = std::make_unique<render::Renderer>(
          scene_->cameras.at(camera), render::lamps_over(model_->extent()), seed_ + camera);
    }
    // A paused cell may change within its step; what did not costs next to nothing.
    const bool noisy = room.renderer->camera().noise > 0 && room.drawn.step != snapshot.step;
    const std::size_t tiles = room.renderer->draw(model_->place(snapshot), snapshot.step);
    if (tiles > 0 || noisy || !room.is_drawn) room.bytes.clear();
    const scene::Lens& lens = room.renderer->camera().lens;
    room.drawn = {snapshot.epoch, snapshot.step, snapshot.time, lens.width_px, lens.height_px, {}};
    room.is_drawn = true;
  }

  Result<std::string> encode(const render::Renderer& renderer, PictureForm form) {
    switch (form) {
      case PictureForm::kJpeg:
        return jpeg_.encode(renderer.rgb(), renderer.camera().jpeg_quality);
      case PictureForm::kRgb:
        return bytes_of(renderer.rgb());
      case PictureForm::kDepth:
        return bytes_of(renderer.depth());
      case PictureForm::kSegments:
        return bytes_of(renderer.segments(model_->object_of()));
      case PictureForm::kNormals:
        return bytes_of(renderer.normals());
    }
    return unavailable("no such form");
  }

  void free_idle() {
    const auto now = Clock::now();
    for (Room& room : rooms_) {
      if (room.renderer && now - room.used >= kIdle) room = {};
    }
  }

  const std::shared_ptr<const scene::Scene> scene_;
  const api::SnapshotSource& source_;
  const std::uint64_t seed_;
  std::vector<protocols::CameraInfo> infos_;

  std::mutex mutex_;
  std::condition_variable asked_;
  std::vector<Request> requests_;
  bool stopping_ = false;

  // For the studio's thread alone.
  std::shared_ptr<const api::CellDescription> cell_;  // of the model
  std::optional<render::CellModel> model_;
  std::vector<Room> rooms_;
  JpegEncoder jpeg_;

  std::thread thread_;
};

CameraStudio::CameraStudio(std::shared_ptr<const scene::Scene> scene,
                           const api::SnapshotSource& source, std::uint64_t seed)
    : impl_(std::make_unique<Impl>(std::move(scene), source, seed)) {}

CameraStudio::~CameraStudio() = default;

const std::vector<protocols::CameraInfo>& CameraStudio::cameras() const { return impl_->cameras(); }

void CameraStudio::take_picture(std::size_t camera, PictureForm form, Done done) {
  impl_->take_picture(camera, form, std::move(done));
}

void CameraStudio::stop() { impl_->stop(); }

}  // namespace aprsim::server
