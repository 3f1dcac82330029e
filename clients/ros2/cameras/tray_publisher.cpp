#include "clients/ros2/cameras/tray_publisher.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "clients/ros2/cameras/picture_stream.hpp"
#include "clients/ros2/dds/messages.hpp"
#include "clients/ros2/dds/tray_messages.hpp"
#include "clients/ros2/trays/tray_area.hpp"

namespace aprsim::ros2 {
namespace {

constexpr double kTraysRate_hz = 1;       // of aprs_vision
constexpr std::size_t kMostPoses = 1000;  // some seconds, for pictures that take long

v1::StreamImagesRequest segments_of(const v1::CameraDescription& camera) {
  v1::StreamImagesRequest request;
  request.set_camera(camera.name());
  request.set_format(v1::IMAGE_FORMAT_SEGMENTATION);
  request.set_rate_hz(kTraysRate_hz);
  return request;
}

}  // namespace

void TrayPublisher::Recent::set_cell(std::shared_ptr<const v1::CellDescription> cell) {
  const std::lock_guard lock(mutex_);
  cell_ = std::move(cell);
}

std::shared_ptr<const v1::CellDescription> TrayPublisher::Recent::cell() const {
  const std::lock_guard lock(mutex_);
  return cell_;
}

void TrayPublisher::Recent::add(const v1::Snapshot& snapshot) {
  BodyPoses poses = poses_of(snapshot);
  const std::lock_guard lock(mutex_);
  poses_.push_back(std::move(poses));
  if (poses_.size() > kMostPoses) poses_.pop_front();
}

BodyPoses TrayPublisher::Recent::at(const v1::Image& image) const {
  const std::lock_guard lock(mutex_);
  const auto distance = [&](const BodyPoses& poses) {
    return poses.step < image.step() ? image.step() - poses.step : poses.step - image.step();
  };
  const BodyPoses* nearest = nullptr;
  for (const auto& poses : poses_) {
    if (poses.epoch != image.epoch()) continue;
    if (!nearest || distance(poses) <= distance(*nearest)) nearest = &poses;
  }
  return nearest ? *nearest : BodyPoses{};
}

/// The area of one camera.
class TrayPublisher::Area {
 public:
  Area(TrayPublisher& publisher, TrayArea area, client::Endpoints daemon,
       v1::CameraDescription camera)
      : publisher_(publisher),
        area_(std::move(area)),
        daemon_(std::move(daemon)),
        camera_(std::move(camera)),
        trays_(publisher.node_.create_writer(publisher.namespace_ + area_.topic, trays_type(), {})),
        pictures_(daemon_, segments_of(camera_), [this](const auto& image) { publish(image); }) {}
  ~Area() {
    pictures_.stop();
    publisher_.node_.remove(trays_);
  }
  Area(const Area&) = delete;
  Area& operator=(const Area&) = delete;

  [[nodiscard]] bool is_same(const TrayArea& area, const client::Endpoints& daemon,
                             const v1::CameraDescription& camera) const {
    return area.topic == area_.topic && area.has_frames == area_.has_frames &&
           daemon.host == daemon_.host && daemon.grpc == daemon_.grpc &&
           daemon.token == daemon_.token &&
           camera.SerializeAsString() == camera_.SerializeAsString();
  }
  [[nodiscard]] bool is_wanted() const { return has_readers(trays_); }
  void update() { pictures_.update(is_wanted()); }

 private:
  void publish(const v1::Image& image) {
    const auto cell = publisher_.recent_.cell();
    const BodyPoses poses = publisher_.recent_.at(image);
    if (!cell || poses.in_world.empty()) return;
    const auto trays = find_trays(*cell, poses, camera_, image);
    write_trays(trays_, poses.time, trays);
    if (area_.has_frames) write_frames(publisher_.frames_, poses.time, frames_of(trays));
  }

  TrayPublisher& publisher_;
  const TrayArea area_;
  const client::Endpoints daemon_;
  const v1::CameraDescription camera_;
  const dds_entity_t trays_;
  PictureStream pictures_;
};

TrayPublisher::TrayPublisher(Node& node, std::string ros_namespace, dds_entity_t frames)
    : node_(node),
      namespace_(ros_namespace == "/" ? "" : std::move(ros_namespace)),
      frames_(frames) {}
TrayPublisher::~TrayPublisher() = default;

void TrayPublisher::set_cell(const client::Endpoints& daemon, const v1::CellDescription& cell) {
  recent_.set_cell(std::make_shared<const v1::CellDescription>(cell));
  std::vector<std::pair<TrayArea, const v1::CameraDescription*>> wanted;
  std::set<std::string> topics;
  for (const auto& camera : cell.cameras()) {
    const auto area = tray_area_of(camera, cell);
    if (area && topics.insert(area->topic).second) wanted.emplace_back(*area, &camera);
  }
  std::vector<std::unique_ptr<Area>> areas;
  for (const auto& [area, camera] : wanted) {
    const auto same = std::ranges::find_if(
        areas_, [&](const auto& one) { return one && one->is_same(area, daemon, *camera); });
    areas.push_back(same == areas_.end() ? nullptr : std::move(*same));
  }
  areas_.clear();  // their names may be used again
  for (std::size_t i = 0; i < areas.size(); ++i) {
    if (areas[i]) continue;
    areas[i] = std::make_unique<Area>(*this, wanted[i].first, daemon, *wanted[i].second);
  }
  areas_ = std::move(areas);
  node_.announce();
}

void TrayPublisher::update(const v1::Snapshot& snapshot) {
  if (std::ranges::any_of(areas_, [](const auto& area) { return area->is_wanted(); })) {
    recent_.add(snapshot);
  }
  for (const auto& area : areas_) area->update();
}

}  // namespace aprsim::ros2
