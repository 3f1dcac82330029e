// Pictures beside the running cell: frames a second of one and five cameras, and what the
// simulation pays for them; then one camera alone against MuJoCo's renderer.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "server/cameras/camera_studio.hpp"
#include "tests/benchmarks/support/clock.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/support/tails.hpp"
#include "tests/support/cell_script.hpp"
#include "tests/support/kitting_demo.hpp"
#include "world/render/cell/cell_model.hpp"
#include "world/render/renderer.hpp"
#include "world/runtime/publish/snapshot_slot.hpp"
#ifdef APRSIM_MUJOCO_PICTURES
#include "tests/benchmarks/cameras/mujoco_pictures.hpp"
#endif

namespace aprsim::bench {
namespace {

using Clock = std::chrono::steady_clock;

/// Snapshots of the cell, as the studio reads them.
class Source final : public api::SnapshotSource {
 public:
  explicit Source(const world::SnapshotSlot& slot) : slot_(slot) {}
  [[nodiscard]] api::SnapshotPtr latest() const override { return slot_.latest(); }
  [[nodiscard]] api::SnapshotPtr wait_newer(const api::SnapshotPtr& seen,
                                            Clock::time_point deadline) const override {
    return slot_.wait_newer(seen, deadline);
  }
  [[nodiscard]] std::string problem() const override { return {}; }

 private:
  const world::SnapshotSlot& slot_;
};

/// The default cell with five cameras of one size: both of the scene, and three beside them.
std::shared_ptr<const scene::Scene> scene_with_cameras(int width, int height) {
  scene::Scene scene = *test::load_scene("aprs");
  const std::vector<scene::Camera> own = scene.cameras;
  while (scene.cameras.size() < 5) {
    scene::Camera copy = own[scene.cameras.size() % own.size()];
    copy.name += fmt::format("_{}", scene.cameras.size());
    copy.X_PC.p.x() += 0.1 * static_cast<double>(scene.cameras.size());
    scene.cameras.push_back(copy);
  }
  for (scene::Camera& camera : scene.cameras) {
    camera.lens.focal_px *= static_cast<double>(height) / camera.lens.height_px;
    camera.lens.width_px = width;
    camera.lens.height_px = height;
    camera.lens.centre_px = {0.5 * (width - 1), 0.5 * (height - 1)};
    camera.lens.distortion = {-0.1, 0, 0, 0, 0};
  }
  return std::make_shared<const scene::Scene>(std::move(scene));
}

/// Steps in real time and publishes each step, as the daemon's simulation thread does.
class Cell {
 public:
  explicit Cell(const std::shared_ptr<const scene::Scene>& scene)
      : world_(scene, 1), demo_(world_, true) {
    for (int step = 0; step < 500; ++step) advance();
  }

  [[nodiscard]] const world::SnapshotSlot& slot() const { return slot_; }

  struct Span {
    std::vector<double> step_us;  ///< wall-clock time of each step and its publication
    double wall_s = 0;
    [[nodiscard]] double pace() const {
      return 1e-3 * static_cast<double>(step_us.size()) / wall_s;
    }
  };

  /// Late steps are made up for, as the daemon does.
  void run(int steps, bool moving, Span& span) {
    const auto begin = Clock::now();
    auto due = begin;
    for (int step = 0; step < steps; ++step) {
      due += std::chrono::milliseconds(1);
      std::this_thread::sleep_until(due);
      const auto start = Clock::now();
      if (moving) demo_.command();
      advance();
      if (moving) demo_.observe();
      span.step_us.push_back(1e6 * std::chrono::duration<double>(Clock::now() - start).count());
    }
    span.wall_s += std::chrono::duration<double>(Clock::now() - begin).count();
  }

 private:
  void advance() {
    world_.step();
    auto snapshot = slot_.acquire();
    world_.write(*snapshot);
    slot_.publish(std::move(snapshot));
  }

  world::World world_;
  test::KittingDemo demo_;
  world::SnapshotSlot slot_;
};

/// Asks for the next JPEG of each camera as soon as the last one has come.
class Viewers {
 public:
  Viewers(server::CameraStudio& studio, std::vector<std::string> cameras)
      : studio_(studio), cameras_(std::move(cameras)) {
    for (const std::string& camera : cameras_) ask(camera);
  }
  ~Viewers() {
    stopping_ = true;
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [this] { return open_ == 0; });
  }
  Viewers(const Viewers&) = delete;
  Viewers& operator=(const Viewers&) = delete;

  [[nodiscard]] std::uint64_t pictures() const { return pictures_; }

 private:
  void ask(const std::string& camera) {
    {
      const std::lock_guard lock(mutex_);
      ++open_;
    }
    studio_.take_picture(camera, protocols::PictureForm::kJpeg,
                         [this, &camera](const aprsim::Result<protocols::CameraPicture>& picture) {
                           if (!picture) throw std::runtime_error(picture.error().message);
                           ++pictures_;
                           if (!stopping_) ask(camera);
                           const std::lock_guard lock(mutex_);
                           if (--open_ == 0) ended_.notify_all();
                         });
  }

  server::CameraStudio& studio_;
  const std::vector<std::string> cameras_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint64_t> pictures_{0};
  std::mutex mutex_;
  std::condition_variable ended_;
  int open_ = 0;
};

struct Size {
  int width = 0, height = 0;
  [[nodiscard]] std::string name() const { return std::to_string(height); }
};
constexpr Size kSizes[] = {{640, 480}, {1920, 1080}};

struct Measured {
  Cell::Span alone, watched;
  std::uint64_t pictures = 0;
  [[nodiscard]] double pictures_hz() const {
    return static_cast<double>(pictures) / watched.wall_s;
  }
};

/// In turns without and with pictures.
Measured measure(const Size& size, int cameras, bool moving, int rounds, int steps) {
  const auto scene = scene_with_cameras(size.width, size.height);
  Cell cell(scene);
  const Source source(cell.slot());
  server::CameraStudio studio(scene, source, {.seed = 1, .max_bytes = std::uint64_t{2} << 30U});
  std::vector<std::string> names;
  for (int i = 0; i < cameras; ++i)
    names.push_back(scene->cameras[static_cast<std::size_t>(i)].name);
  Measured out;
  Cell::Span first;  // in which the renderers are made
  {
    const Viewers viewers(studio, names);
    cell.run(steps / 2, moving, first);
  }
  for (int round = 0; round < rounds; ++round) {
    cell.run(steps, moving, out.alone);
    const Viewers viewers(studio, names);
    cell.run(steps, moving, out.watched);
    out.pictures += viewers.pictures();
  }
  return out;
}

/// Frames a second of one thread that draws all of a picture, as a camera that moves does.
double own_frames_hz(const Size& size, int frames) {
  const auto scene = scene_with_cameras(size.width, size.height);
  const world::World world(scene, 1);
  api::Snapshot snapshot;
  world.write(snapshot);
  auto model = render::CellModel::make(*scene, *snapshot.cell).value();
  const scene::Camera& camera = scene->cameras[0];
  render::Renderer renderer(camera, render::lamps_over(model.extent()), 1);
  const auto& placements = model.place(snapshot);
  Eigen::Isometry3d X_WC = camera.X_PC.isometry();
  double start = 0;
  for (int i = -1; i < frames; ++i) {
    if (i == 0) start = thread_cpu_s();
    X_WC.translation().x() += 1e-3;
    renderer.set_camera(camera, X_WC, 0);
    if (!renderer.draw(placements, static_cast<std::uint64_t>(i + 2))) {
      throw std::runtime_error("too little memory");
    }
  }
  return frames / (thread_cpu_s() - start);
}

#ifdef APRSIM_MUJOCO_PICTURES
double mujoco_frames_hz(const Size& size, int frames) {
  const auto scene = scene_with_cameras(size.width, size.height);
  const world::World world(scene, 1);
  api::Snapshot snapshot;
  world.write(snapshot);
  MujocoPictures pictures(*scene, snapshot, size.width, size.height);
  double start = 0;
  for (int i = -1; i < frames; ++i) {
    if (i == 0) start = thread_cpu_s();
    if (!(pictures.draw() > 1)) throw std::runtime_error("MuJoCo: a black picture");
  }
  return frames / (thread_cpu_s() - start);
}
#endif

void race(Experiment& experiment) {
  const int frames = experiment.quick() ? 1 : 20;
  for (const Size& size : kSizes) {
    const std::string own_name = "cameras.all_moving_hz." + size.name();
    const double own = own_frames_hz(size, frames);
    experiment.record(own_name, own, "Hz");
#ifdef APRSIM_MUJOCO_PICTURES
    const double other = mujoco_frames_hz(size, frames);
    const std::string other_name = "cameras.mujoco_hz." + size.name();
    experiment.record(other_name, other, "Hz");
    experiment.record(
        {"cameras.over_mujoco." + size.name(), own / other, "x", other_name, own / other});
#endif
  }
#ifdef APRSIM_MUJOCO_PICTURES
  experiment.version("MuJoCo", MujocoPictures::version());
  experiment.note(
      "`all_moving`: every tile of one camera drawn again in one thread, CPU time, with two soft "
      "shadows, "
      "markers, teeth and arms. MuJoCo draws the same cell by Mesa's software OpenGL in one "
      "thread: trays as "
      "boxes, gears as two cylinders, no arms, one hard shadow, no distortion.");
#endif
}

int run(int argc, char** argv) {
  Experiment experiment("cameras", argc, argv);
  const int rounds = experiment.quick() ? 1 : 5, steps = experiment.quick() ? 300 : 3000;
  Table table({"cell", "cameras", "pictures", "pictures a second", "pace alone", "pace beside",
               "step p99.9 alone [us]", "beside [us]", "ratio"});
  double least_pace_ratio = 1, most_step_ratio = 0;
  for (const bool moving : {false, true}) {
    for (const Size& size : kSizes) {
      for (const int cameras : {1, 5}) {
        // A quick run has the cases that figures name.
        const bool named = moving && (size.height == 1080) == (cameras == 5);
        if (experiment.quick() && !named) continue;
        const Measured seen = measure(size, cameras, moving, rounds, steps);
        const double alone = percentile(seen.alone.step_us, 0.999);
        const double beside = percentile(seen.watched.step_us, 0.999);
        const std::string what =
            fmt::format("{}_{}_{}", moving ? "moving" : "resting", size.name(), cameras);
        table.row({std::string(moving ? "both arms move" : "at rest"), std::to_string(cameras),
                   fmt::format("{} x {}", size.width, size.height), seen.pictures_hz(),
                   seen.alone.pace(), seen.watched.pace(), alone, beside, beside / alone});
        experiment.record("cameras.pictures_hz." + what, seen.pictures_hz(), "Hz");
        least_pace_ratio = std::min(least_pace_ratio, seen.watched.pace() / seen.alone.pace());
        most_step_ratio = std::max(most_step_ratio, beside / alone);
        if (!moving || size.height != 1080 || cameras != 5) continue;
        Plot plot{.title = "Default cell in real time: step and publishing",
                  .x = {.label = "fraction of steps that take longer", .log = true},
                  .y = {.label = "us", .log = true},
                  .series = {tails("no camera", seen.alone.step_us),
                             tails("five of 1920 x 1080", seen.watched.step_us)}};
        experiment.plot("tails", plot);
      }
    }
  }
  experiment.table("cameras", "Pictures beside the default cell in real time", table);
  experiment.record("cameras.least_pace_ratio", least_pace_ratio, "x");
  experiment.record("cameras.most_step_p999_ratio", most_step_ratio, "x");
  race(experiment);
  experiment.note(
      "Each camera's next JPEG picture is asked for when the last one has come, all of one studio, "
      "which is one "
      "thread of lower priority in the process of the cell. Steps are timed by the wall clock, in "
      "turns without "
      "and with pictures; `pictures a second` is the sum over the cameras.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
