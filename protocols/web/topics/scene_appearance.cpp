#include "protocols/web/topics/scene_appearance.hpp"

#include "protocols/web/topics/visual_message.hpp"

namespace aprsim::web {
namespace {

const std::string& text_of(const api::CellDescription& cell) {
  static const std::string none;
  return cell.scene_text ? *cell.scene_text : none;
}

}  // namespace

bool same_scene(const api::CellDescription& a, const api::CellDescription& b) {
  return a.scene == b.scene && a.bodies.size() == b.bodies.size() && text_of(a) == text_of(b);
}

bool SceneAppearance::follow(const api::CellDescription& cell, const Describe& describe) {
  if (known_ && scene_ == cell.scene && text_ == text_of(cell)) return false;
  known_ = true;
  scene_ = cell.scene;
  text_ = text_of(cell);
  message_.Clear();
  if (describe) write_message(describe(cell), message_);
  return true;
}

}  // namespace aprsim::web
