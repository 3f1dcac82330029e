#pragma once

#include <array>
#include <cstring>
#include <memory>
#include <mujoco/mujoco.h>
#include <stdexcept>
#include <string>

namespace aprsim::bench {

/// The model of an MJCF text, to be deleted by mj_deleteModel(). Throws std::runtime_error with
/// MuJoCo's words.
[[nodiscard]] inline mjModel* load_mujoco_model(const std::string& xml) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "scene.xml", static_cast<int>(xml.size()));
  std::memcpy(files->filedata[0], xml.data(), xml.size());
  std::array<char, 500> error{};
  mjModel* model = mj_loadXML("scene.xml", files.get(), error.data(), error.size());
  mj_deleteVFS(files.get());
  if (model == nullptr) throw std::runtime_error(std::string("MuJoCo: ") + error.data());
  return model;
}

}  // namespace aprsim::bench
