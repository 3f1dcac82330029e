#pragma once

#include <functional>
#include <string>

#include "aprsim/v1/web.pb.h"
#include "protocols/web/topics/visual_description.hpp"
#include "world/api/description/cell_description.hpp"

namespace aprsim::web {

/// Whether both are described by the same scene, with what was changed of it.
[[nodiscard]] bool same_scene(const api::CellDescription& a, const api::CellDescription& b);

/// The looks of a cell, worked out anew when its scene is another one than before.
class SceneLooks {
 public:
  using Describe = std::function<VisualDescription(const api::CellDescription&)>;

  /// Whether they are others than the last time.
  bool follow(const api::CellDescription& cell, const Describe& describe);
  [[nodiscard]] const v1::CellLooks& message() const { return message_; }

 private:
  bool known_ = false;
  std::string scene_, text_;
  v1::CellLooks message_;
};

}  // namespace aprsim::web
