#include "server/replay/motion_file.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <utility>

#include "aprsim/v1/motion.pb.h"
#include "protocols/messages/write_message.hpp"
#include "protocols/web/topics/scene_appearance.hpp"
#include "protocols/web/topics/visual_message.hpp"
#include "server/listeners/visual_description.hpp"

namespace aprsim::server {
namespace {

double seconds(SimTime time) { return std::chrono::duration<double>(time).count(); }

/// Steps between two samples.
std::uint64_t steps_between(const MotionOptions& options, double step_s) {
  return static_cast<std::uint64_t>(
      std::max(1LL, std::llround(1 / (std::max(options.rate_hz, 1e-6) * step_s))));
}

}  // namespace

MotionFile::MotionFile(MotionOptions options, const v1::JournalHeader& header,
                       const scene::Scene& scene)
    : options_(std::move(options)), file_(options_.file), header_(header), scene_(scene) {
  file_.out() << aprsim::journal::kMagic;
}

void MotionFile::describe(const world::World& world) {
  v1::MotionRecord record;
  v1::MotionHeader& out = *record.mutable_header();
  protocols::write_message(*world.description(), *out.mutable_cell());
  web::write_message(visual_of(*world.scene()), *out.mutable_appearance());
  for (const scene::Robot& robot : scene_.robots) {
    if (described_) break;
    std::ifstream model(robot.model_file, std::ios::binary);
    v1::JournalFile& file = *out.add_models();
    file.set_name(robot.name);
    file.set_content(std::string(std::istreambuf_iterator<char>(model), {}));
  }
  const double step_s = seconds(world.step_size());
  out.set_rate_hz(1 / (static_cast<double>(steps_between(options_, step_s)) * step_s));
  out.set_run_id(header_.run_id());
  encoder_.add(record);
  described_ = world.description();
}

void MotionFile::sample(const world::World& world, world::RunTime time) {
  const double now_s = seconds(world.time()), step_s = seconds(world.step_size());
  if (time.epoch != epoch_) base_s_ = latest_s_ - now_s;
  epoch_ = time.epoch;
  latest_s_ = std::max(latest_s_, base_s_ + now_s);
  const auto step = static_cast<std::uint64_t>(std::llround(latest_s_ / step_s));
  // The function is also called after commands.
  if (step < next_step_) return;
  next_step_ = step + steps_between(options_, step_s);
  if (latest_s_ < options_.from_s || latest_s_ > options_.to_s) return;
  if (!described_ || !web::same_scene(*described_, *world.description())) describe(world);
  api::Snapshot snapshot;
  world.write(snapshot);
  snapshot.epoch = time.epoch;
  v1::MotionRecord record;
  protocols::write_message(snapshot, header_.run_id(), *record.mutable_snapshot());
  // It would be the wall time of the replay.
  record.mutable_snapshot()->clear_sample_time();
  encoder_.add(record);
  flush(aprsim::journal::kFrameBytes);
}

void MotionFile::flush(std::size_t from_bytes) {
  if (encoder_.pending() >= from_bytes) file_.out() << encoder_.take();
}

Result<void> MotionFile::finish() {
  flush(0);
  return file_.commit();
}

}  // namespace aprsim::server
