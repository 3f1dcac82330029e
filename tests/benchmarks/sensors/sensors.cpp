// Cost of the optical sensors of the default cell: gathering the solids, one scan of the light
// curtain, one exposure of each camera with occluding arms and parts.

#include <functional>
#include <memory>
#include <span>
#include <stdexcept>

#include "tests/benchmarks/support/clock.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/support/cell_script.hpp"
#include "world/cell/observation/sensor_occluders.hpp"
#include "world/sensors/light_curtain.hpp"
#include "world/sensors/overhead_camera.hpp"

namespace aprsim::bench {
namespace {

/// The default cell as its sensors find it at the start.
class Cell {
 public:
  Cell() {
    std::vector<std::vector<Eigen::Isometry3d>> X_WL;
    for (const auto& robot : scene_->robots) {
      models_.push_back(robot::load_arm_model(robot.model_file).value());
    }
    robots_.reserve(models_.size());
    for (std::size_t i = 0; i < models_.size(); ++i) {
      robots_.emplace_back(*scene_, i, models_[i]);
      const auto links = robots_.back().X_WL();
      X_WL.emplace_back(links.begin(), links.end());
    }
    physics_ = std::make_unique<physics::PhysicsWorld>(*scene_, models_, X_WL);
    occluders_ = std::make_unique<world::SensorOccluders>(*scene_, models_);
    gather({});
  }

  void gather(const std::optional<api::Intruder>& intruder) {
    occluders_->gather(robots_, *physics_,
                       intruder ? std::span(&*intruder, 1) : std::span<const api::Intruder>());
  }
  [[nodiscard]] const scene::Scene& scene() const { return *scene_; }
  [[nodiscard]] const world::SensorOccluders& occluders() const { return *occluders_; }
  [[nodiscard]] std::vector<sensors::Occluder> arms_alone() const {
    std::vector<sensors::Occluder> arms;
    for (const auto& occluder : occluders_->all()) {
      if (occluder.body < 0) arms.push_back(occluder);
    }
    return arms;
  }

 private:
  std::shared_ptr<const scene::Scene> scene_ = test::load_scene("aprs");
  std::vector<robot::ArmModel> models_;
  std::vector<world::SimulatedRobot> robots_;
  std::unique_ptr<physics::PhysicsWorld> physics_;
  std::unique_ptr<world::SensorOccluders> occluders_;
};

/// CPU time of one call [us], the median of so many rounds of 100 calls.
double cost_us(int rounds, const std::function<void()>& call) {
  constexpr int kCalls = 100;
  std::vector<double> samples;
  for (int round = 0; round < rounds; ++round) {
    const double start = thread_cpu_s();
    for (int i = 0; i < kCalls; ++i) call();
    samples.push_back(1e6 * (thread_cpu_s() - start) / kCalls);
  }
  return median(samples);
}

int run(int argc, char** argv) {
  Experiment experiment("sensors", argc, argv);
  const int rounds = experiment.quick() ? 5 : 101;
  Cell cell;
  const std::vector<scene::FreeBody> bodies = scene::free_bodies_of(cell.scene());
  Table table({"what", "CPU time [us]", "every [ms]"});
  const auto record = [&](const std::string& name, const std::string& what, double us,
                          double period_ms) {
    experiment.record("sensors." + name + "_us", us, "us");
    table.row({what, us, period_ms});
  };
  record("gather", "gathering the solids", cost_us(rounds, [&] { cell.gather({}); }), 10);

  const sensors::LightCurtain curtain(*cell.scene().light_curtain);
  double sum = 0;
  const auto measure = [&] { sum += curtain.measure(cell.occluders().all()).distance_m[0]; };
  record("curtain_clear", "light curtain, clear", cost_us(rounds, look), 10);
  api::Intruder person;
  person.X_WI.p = {0, -1.75, 0.9};
  person.size_m = {0.5, 0.3, 1.8};
  cell.gather(person);
  record("curtain_broken", "light curtain, a person in it", cost_us(rounds, look), 10);
  cell.gather({});

  const auto& robot = cell.scene().robots[0];
  const sensors::OverheadCamera camera(robot.vision, robot.X_WB.isometry() * robot.X_BR.isometry());
  api::VisionFrame frame;
  const double period_ms = 1e3 / robot.vision.rate_hz;
  const std::vector<sensors::Occluder> arms = cell.arms_alone();
  const double without =
      cost_us(rounds, [&] { camera.detect(bodies, cell.occluders().X_WP(), arms, 1, frame); });
  const double with = cost_us(rounds, [&] {
    camera.detect(bodies, cell.occluders().X_WP(), cell.occluders().all(), 1, frame);
  });
  table.row({"camera, arms in its way", without, period_ms});
  table.row({"camera, arms, trays and gears in its way", with, period_ms});
  experiment.record("sensors.camera_arms_us", without, "us");
  experiment.record({"sensors.camera_us", with, "us", "arms alone", with / without});
  experiment.table("costs", "Optical sensors of the default cell", table);
  Series growing{"a person in it", {}};
  cell.gather(person);
  for (int beams = 1; beams <= 64; beams *= 2) {
    auto size = *cell.scene().light_curtain;
    size.beams = beams;
    const sensors::LightCurtain one(size);
    growing.points.emplace_back(
        beams, cost_us(rounds, [&] { sum += one.measure(cell.occluders().all()).distance_m[0]; }));
  }
  experiment.plot("curtain", {.title = "One look through a light curtain",
                              .x = {.label = "beams"},
                              .y = {.label = "us"},
                              .series = {growing}});
  if (!(sum > 0)) throw std::runtime_error("no beam was looked along");
  experiment.note("CPU time of the calling thread, median of rounds of 100 calls.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
