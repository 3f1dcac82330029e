#include "clients/ros2/cameras/camera_publisher.hpp"

#include <algorithm>
#include <utility>

#include "clients/ros2/cameras/picture_stream.hpp"
#include "clients/ros2/cell/frames.hpp"
#include "clients/ros2/cell/names.hpp"
#include "clients/ros2/dds/image_messages.hpp"
#include "clients/ros2/dds/messages.hpp"

namespace aprsim::ros2 {
namespace {

constexpr Quality kSensorData{.depth = 5, .reliable = false};  // rmw_qos_profile_sensor_data

v1::StreamImagesRequest request_of(const v1::CameraDescription& camera) {
  v1::StreamImagesRequest request;
  request.set_camera(camera.name());
  request.set_format(v1::IMAGE_FORMAT_RGB);
  return request;
}

}  // namespace

/// One camera.
class CameraPublisher::Camera {
 public:
  Camera(Node& node, const std::string& ros_namespace, client::Endpoints daemon,
         v1::CameraDescription camera, dds_entity_t frames)
      : node_(node),
        daemon_(std::move(daemon)),
        camera_(std::move(camera)),
        frame_(ros_token(camera_.name()) + "_optical_frame"),
        frames_(frames),
        pictures_(daemon_, request_of(camera_), [this](const auto& image) { publish(image); }) {
    const std::string topic = ros_namespace + "/" + ros_token(camera_.name());
    images_ = node.create_writer(topic + "/image_raw", image_type(), kSensorData);
    infos_ = node.create_writer(topic + "/camera_info", camera_info_type(), kSensorData);
  }
  ~Camera() {
    pictures_.stop();
    node_.remove(images_);
    node_.remove(infos_);
  }
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  [[nodiscard]] bool is_same(const client::Endpoints& daemon,
                             const v1::CameraDescription& camera) const {
    return daemon.host == daemon_.host && daemon.grpc == daemon_.grpc &&
           daemon.token == daemon_.token &&
           camera.SerializeAsString() == camera_.SerializeAsString();
  }

  /// Begins or ends the pictures. Throws the error that has ended them.
  void update() { pictures_.update(has_readers(images_) || has_readers(infos_)); }

 private:
  void publish(const v1::Image& image) {
    if (has_readers(images_)) write_image(images_, frame_, image);
    write_camera_info(infos_, frame_, camera_, image);
    if (camera_.has_camera_in_world()) return;  // its frame is a fixed one
    write_frames(frames_, image.sim_time(), {{frame_, image.camera_in_world()}});
  }

  Node& node_;
  const client::Endpoints daemon_;
  const v1::CameraDescription camera_;
  const std::string frame_;
  dds_entity_t frames_, images_ = 0, infos_ = 0;
  PictureStream pictures_;
};

CameraPublisher::CameraPublisher(Node& node, std::string ros_namespace, dds_entity_t frames)
    : node_(node),
      namespace_(ros_namespace == "/" ? "" : std::move(ros_namespace)),
      frames_(frames) {}
CameraPublisher::~CameraPublisher() = default;

void CameraPublisher::set_cell(const client::Endpoints& daemon, const v1::CellDescription& cell) {
  std::vector<std::unique_ptr<Camera>> cameras;
  for (const auto& camera : cell.cameras()) {
    const auto old = std::ranges::find_if(
        cameras_, [&](const auto& one) { return one && one->is_same(daemon, camera); });
    cameras.push_back(old == cameras_.end() ? nullptr : std::move(*old));
  }
  cameras_.clear();  // their names may be used again
  for (int i = 0; i < cell.cameras_size(); ++i) {
    auto& camera = cameras[static_cast<std::size_t>(i)];
    if (camera) continue;
    camera = std::make_unique<Camera>(node_, namespace_, daemon, cell.cameras(i), frames_);
  }
  cameras_ = std::move(cameras);
  node_.announce();
}

void CameraPublisher::update() {
  for (const auto& camera : cameras_) camera->update();
}

}  // namespace aprsim::ros2
