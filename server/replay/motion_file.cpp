#include "server/replay/motion_file.hpp"

#include <fstream>
#include <iterator>
#include <string>

#include "aprsim/v1/motion.pb.h"
#include "protocols/messages/write_message.hpp"
#include "protocols/web/topics/scene_appearance.hpp"
#include "protocols/web/topics/visual_message.hpp"
#include "server/listeners/visual_description.hpp"

namespace aprsim::server {
MotionFile::MotionFile(const MotionOptions& options, const v1::JournalHeader& header)
    : times_(options), file_(options.file), header_(header) {
  file_.out() << aprsim::journal::kMagic;
}

void MotionFile::describe(const world::World& world) {
  v1::MotionRecord record;
  v1::MotionHeader& out = *record.mutable_header();
  protocols::write_message(*world.description(), *out.mutable_cell());
  web::write_message(visual_of(*world.scene()), *out.mutable_appearance());
  for (const scene::Robot& robot : world.scene()->robots) {
    std::ifstream model(robot.model_file, std::ios::binary);
    v1::JournalFile& file = *out.add_models();
    file.set_name(robot.name);
    file.set_content(std::string(std::istreambuf_iterator<char>(model), {}));
  }
  out.set_rate_hz(times_.rate_hz(world));
  out.set_run_id(header_.run_id());
  encoder_.add(record);
  described_ = world.description();
}

void MotionFile::sample(const world::World& world, world::RunTime time) {
  if (!times_.is_due(world, time)) return;
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
