#include "server/journal/scene_writer.hpp"

#include <set>
#include <stdexcept>
#include <utility>
#include <variant>

#include "server/journal/run_header.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server::journal {

SceneWriter::SceneWriter(const v1::JournalHeader& header, const StateSeal& seal)
    : header_text_(header.scene_text()), seal_(seal) {
  for (const v1::JournalFile& model : header.models()) models_[model.name()] = model.sha256();
}

const v1::JournalScene& SceneWriter::message_of(const ScenePtr& scene, Written& last) {
  if (last.scene == scene) return last.message;
  auto text = scene::portable_text(scene->text, scene->file);
  if (!text) throw std::runtime_error(text.error().message);
  v1::JournalScene message;
  message.set_name(scene->name);
  message.set_text(*std::move(text));
  std::set<std::string> files;
  for (const scene::Robot& robot : scene->robots) files.insert(robot.model_file);
  for (const std::string& file : files) {
    auto model = model_message(file);
    if (!model) throw std::runtime_error(model.error().message);
    const auto known = models_.find(model->name());
    if (known != models_.end() && known->second == model->sha256()) continue;
    *message.add_models() = *std::move(model);
  }
  last = {scene, std::move(message)};
  return last.message;
}

void SceneWriter::write(const Entry& entry, v1::JournalRecord& record) {
  if (const auto* epoch = std::get_if<EpochBegun>(&entry.what)) {
    if (!epoch->scene) return;
    const v1::JournalScene& message = message_of(epoch->scene, base_);
    if (message.text() != header_text_) *record.mutable_epoch()->mutable_scene() = message;
  } else if (const auto* saved = std::get_if<StateSaved>(&entry.what)) {
    if (saved->state->scene) write(*saved->state, *record.mutable_checkpoint());
  }
}

void SceneWriter::write(const world::WorldState& state, v1::JournalCheckpoint& checkpoint) {
  const v1::JournalScene& base = message_of(state.base_scene(), base_);
  if (base.text() != header_text_) *checkpoint.mutable_scene() = base;
  if (state.base) *checkpoint.mutable_changed_scene() = message_of(state.scene, changed_);
  seal_.sign(header_text_, checkpoint);
}

}  // namespace aprsim::server::journal
