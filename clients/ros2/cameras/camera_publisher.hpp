#pragma once

#include <memory>
#include <string>
#include <vector>

#include "aprsim/v1/cell.pb.h"
#include "clients/ros2/dds/node.hpp"
#include "clients/wires/endpoints.hpp"

namespace aprsim::ros2 {

/// Publishes pictures of the cell's cameras: /CAMERA/image_raw and /CAMERA/camera_info, and in /tf
/// the frames of cameras on flanges. A camera takes pictures only while somebody subscribes to one
/// of its topics; each has a thread of its own then. Thread: one. Errors of DDS:
/// std::runtime_error.
class CameraPublisher {
 public:
  /// `ros_namespace`: before the names of topics, "/" = none. `frames`: writer of /tf.
  CameraPublisher(Node& node, std::string ros_namespace, dds_entity_t frames);
  ~CameraPublisher();
  CameraPublisher(const CameraPublisher&) = delete;
  CameraPublisher& operator=(const CameraPublisher&) = delete;

  /// The cell and its daemon from now on.
  void set_cell(const client::Endpoints& daemon, const v1::CellDescription& cell);
  /// Begins and ends pictures as nodes subscribe and leave; to be called often.
  void update();

 private:
  class Camera;

  Node& node_;
  std::string namespace_;
  dds_entity_t frames_;
  std::vector<std::unique_ptr<Camera>> cameras_;
};

}  // namespace aprsim::ros2
