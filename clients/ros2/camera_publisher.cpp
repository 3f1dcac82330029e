#include "clients/ros2/camera_publisher.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <iostream>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "clients/ros2/cell/frames.hpp"
#include "clients/ros2/cell/names.hpp"
#include "clients/ros2/dds/image_messages.hpp"
#include "clients/ros2/dds/messages.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::ros2 {
namespace {

constexpr Quality kSensorData{.depth = 5, .reliable = false};  // rmw_qos_profile_sensor_data
constexpr std::chrono::seconds kPictureRetry{1};

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
        frames_(frames) {
    const std::string topic = ros_namespace + "/" + ros_token(camera_.name());
    images_ = node.create_writer(topic + "/image_raw", image_type(), kSensorData);
    infos_ = node.create_writer(topic + "/camera_info", camera_info_type(), kSensorData);
  }
  ~Camera() {
    stop();
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
  void update() {
    if (has_failed_) {
      stop();
      std::rethrow_exception(error_);
    }
    // A thread ends with its next picture, for which nobody waits here.
    if (is_over_ && thread_.joinable()) thread_.join();
    const bool wanted = is_wanted();
    stopping_ = !wanted;
    if (!wanted || thread_.joinable()) return;
    is_over_ = false;
    thread_ = std::thread([this] { run(); });
  }

 private:
  [[nodiscard]] bool is_wanted() const { return has_readers(images_) || has_readers(infos_); }

  void stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }

  void run() {
    std::string reported;
    while (!stopping_) {
      const auto done = stream();
      if (!done && done.error().message != reported) {
        reported = done.error().message;
        std::cerr << fmt::format("aprsim-ros2: camera {}: {}; trying again\n", camera_.name(),
                                 reported);
      }
      client::sleep_until(std::chrono::steady_clock::now() + kPictureRetry,
                          [this] { return stopping_.load(); });
    }
    is_over_ = true;
  }

  client::Outcome<void> stream() {
    client::CellConnection connection(daemon_);
    v1::StreamImagesRequest request;
    request.set_camera(camera_.name());
    request.set_format(v1::IMAGE_FORMAT_RGB);
    return connection.images(request, [this](const v1::StreamImagesResponse& response) {
      if (!stopping_) publish(response.image());
      return !stopping_;
    });
  }

  void publish(const v1::Image& image) {
    try {
      if (has_readers(images_)) write_image(images_, frame_, image);
      write_camera_info(infos_, frame_, camera_, image);
      if (camera_.has_camera_in_world()) return;  // its frame is a fixed one
      write_frames(frames_, image.sim_time(), {{frame_, image.camera_in_world()}});
    } catch (const std::exception&) {
      error_ = std::current_exception();
      has_failed_ = true;
      stopping_ = true;
    }
  }

  Node& node_;
  const client::Endpoints daemon_;
  const v1::CameraDescription camera_;
  const std::string frame_;
  dds_entity_t frames_, images_ = 0, infos_ = 0;
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> is_over_ = false;  ///< the thread only has to be joined
  std::atomic<bool> has_failed_ = false;
  std::exception_ptr error_;  ///< of the thread; read once it has failed
  std::thread thread_;
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
