#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"
#include "world/render/raster/rasterizer.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::render {

/// One thing that a segmented picture tells apart. Its id is its place in the list.
struct SceneObject {
  enum class Kind { kNothing, kBody, kRobot, kTool, kFixed, kBelt, kFloor, kIntruder };
  Kind kind = Kind::kNothing;
  std::string name;
};

/// The looks of a cell: meshes that never change, and where a snapshot puts them. Thread: one at a
/// time.
class CellModel {
 public:
  /// From the scene and the description that belongs to it. Error: a robot's model cannot be read.
  [[nodiscard]] static Result<CellModel> make(const scene::Scene& scene,
                                              const api::CellDescription& cell);

  /// Everything at the instant of a snapshot of this cell, always in the same order.
  [[nodiscard]] const std::vector<Placement>& place(const api::Snapshot& snapshot);

  /// The first is nothing; bodies follow in the order of the description.
  [[nodiscard]] const std::vector<SceneObject>& objects() const { return objects_; }
  /// The object of each placement.
  [[nodiscard]] const std::vector<std::uint16_t>& object_of() const { return object_of_; }
  /// Pose of a robot's flange in the world, as it was placed last.
  [[nodiscard]] const Eigen::Isometry3d& X_WF(std::size_t robot) const;
  /// Pose of a camera of the scene in the world, likewise.
  [[nodiscard]] Pose X_WC(const scene::Camera& camera) const;
  /// Memory of the meshes.
  [[nodiscard]] std::uint64_t bytes() const;
  /// Box around what stands in the cell, the floor left out.
  [[nodiscard]] const Eigen::AlignedBox3d& extent() const { return extent_; }

 private:
  struct Arm {
    robot::ArmModel model;
    Pose X_WB;
    std::size_t first = 0;  ///< of its links' placements
  };
  struct Tool {
    std::size_t body = 0;
    std::optional<std::size_t> fingers;  ///< the one at +y, then the one at -y
    double gap_open_m = 0;
  };

  CellModel() = default;
  std::uint16_t add_object(SceneObject::Kind kind, const std::string& name);
  std::size_t add(Mesh mesh, std::uint16_t object, const Pose& X_W = {});
  std::size_t add_shared(const Mesh* mesh, std::uint16_t object);
  void add_bodies(const scene::Scene& scene);
  Result<void> add_robots(const scene::Scene& scene);
  void add_tools(const api::CellDescription& cell);
  void add_surroundings(const scene::Scene& scene);
  void place_tool(const Tool& tool, const api::ToolSnapshot& state, const api::Snapshot& snapshot);

  std::unique_ptr<std::deque<Mesh>> meshes_ = std::make_unique<std::deque<Mesh>>();
  std::vector<SceneObject> objects_;
  std::vector<Placement> placements_;
  std::vector<std::uint16_t> object_of_;
  std::vector<std::size_t> bodies_;
  std::vector<Arm> arms_;
  std::vector<Tool> tools_;
  std::optional<std::size_t> belt_;
  std::size_t intruder_ = 0;
  Eigen::AlignedBox3d extent_;
};

}  // namespace aprsim::render
