#pragma once

#include <functional>
#include <string>

#include "aprsim/v1/web.pb.h"
#include "protocols/web/topics/visual_description.hpp"
#include "world/api/description/cell_description.hpp"

namespace aprsim::web {

/// Whether both cells have the same scene, edits included.
[[nodiscard]] bool same_scene(const api::CellDescription& a, const api::CellDescription& b);

/// Appearance of a cell, recomputed when its scene changes.
class SceneAppearance {
 public:
  using Describe = std::function<VisualDescription(const api::CellDescription&)>;

  /// Returns whether it has changed since the last call.
  bool follow(const api::CellDescription& cell, const Describe& describe);
  [[nodiscard]] const v1::CellAppearance& message() const { return message_; }

 private:
  bool known_ = false;
  std::string scene_, text_;
  v1::CellAppearance message_;
};

}  // namespace aprsim::web
