#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "protocols/crcl/crcl_server.hpp"
#include "protocols/ports/robot_port.hpp"
#include "protocols/simple_message/simple_message_server.hpp"
#include "protocols/vision/vision_server.hpp"
#include "server/listeners/robot_view.hpp"
#include "server/operations/ports_file.hpp"
#include "world/api/ports/ports.hpp"
#include "world/base/result.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

/// Options of a robot's listeners; ports of 0 are any free ones.
struct RobotListenerOptions {
  crcl_server::CrclServerOptions crcl;
  vision_server::VisionServerOptions vision;
  std::optional<simple_message::SimpleMessageOptions> simple_message;  ///< none = it has none
};

/// The listeners of the present scene's robots. Where another scene is loaded, those of robots that
/// are gone close, and those of new robots open. A robot of the same name, model and ports keeps
/// its listeners and their clients, also at another place in the scene.
class RobotListeners final : public protocols::RobotPorts {
 public:
  using ScenePtr = std::shared_ptr<const scene::Scene>;
  using Clock = std::chrono::steady_clock;

  struct Source {
    std::function<ScenePtr()> scene;  ///< loaded last
    api::CommandSink& sink;
    const api::SnapshotSource& snapshots;
    std::function<RobotListenerOptions(const scene::Scene&, std::size_t index)> options;
    std::size_t max_unfinished_bytes = 0;  ///< of CRCL documents of all robots together
  };
  /// Statistics of one kind of listener, by robot.
  template <typename Stats>
  using ByRobot = std::map<std::string, Stats>;

  /// The references of `source` outlive the listeners.
  explicit RobotListeners(Source source) : source_(std::move(source)) {}
  ~RobotListeners() override { stop(); }

  /// Opens those of the present scene. Error: that of the first that cannot listen; its field is
  /// the listener's name, "crcl.fanuc". Once only. Thread: the owner's.
  [[nodiscard]] Result<void> start();
  /// Checks that the ports of a scene's robots can be bound once those of the present robots are
  /// closed that the scene lacks. Errors: as of start(). Thread: any.
  [[nodiscard]] Result<void> check(const scene::Scene& next) const;
  /// Follows the present scene; returns its description. Listeners that cannot listen are logged
  /// and retried. Thread: one.
  std::shared_ptr<const api::CellDescription> update();
  /// Closes all; every later update() does nothing. Thread: the owner's.
  void stop();

  // Thread: any.

  /// Why a robot of the scene cannot be reached; empty = all can.
  [[nodiscard]] std::string problem() const;
  [[nodiscard]] Ports ports() const;
  [[nodiscard]] ByRobot<crcl_server::CrclServerStats> crcl_stats() const;
  [[nodiscard]] ByRobot<vision_server::VisionServerStats> vision_stats() const;
  [[nodiscard]] ByRobot<simple_message::SimpleMessageStats> simple_message_stats() const;

  [[nodiscard]] std::shared_ptr<protocols::RobotPort> find(const std::string& robot) const override;
  [[nodiscard]] std::vector<std::string> names() const override;

 private:
  /// Members refer to those before them.
  struct Robot {
    RobotListenerOptions options;
    api::RobotDescription description;
    int index = 0;
    api::EndpointId number = 0;  ///< of its endpoints, behind the first ones
    std::shared_ptr<RobotView> crcl_view, vision_view, message_view;
    std::shared_ptr<crcl_server::CrclServer> crcl;
    std::shared_ptr<vision_server::VisionServer> vision;
    std::shared_ptr<simple_message::SimpleMessageServer> simple_message;  ///< null = none
    Ports ports;

    void stop() const;
    void forget_messages(const std::string& name);
    void move_to(int place, const api::SnapshotPtr& now);
  };
  using Robots = std::map<std::string, std::shared_ptr<Robot>>;

  /// CRCL and camera.
  [[nodiscard]] Result<std::shared_ptr<Robot>> open(const scene::Scene& scene, std::size_t index,
                                                    const api::SnapshotPtr& now) const;
  /// The robot with Simple Message as well.
  [[nodiscard]] Result<std::shared_ptr<Robot>> with_messages(const Robot& robot,
                                                             const std::string& name,
                                                             const scene::Scene& scene,
                                                             const api::SnapshotPtr& now) const;
  /// Opens what the scene's robot lacks.
  [[nodiscard]] Result<void> complete(const scene::Scene& scene, std::size_t index,
                                      const api::SnapshotPtr& now);
  void replace(const std::string& name, std::shared_ptr<Robot> robot);
  [[nodiscard]] api::EndpointId free_number() const;
  void close_others(const scene::Scene& scene, const api::SnapshotPtr& now);
  void open_missing(const scene::Scene& scene, const api::SnapshotPtr& now);
  void share_memory() const;
  [[nodiscard]] Robots robots() const;
  template <typename Stats, typename Query>
  [[nodiscard]] ByRobot<Stats> stats_of(const Query& query) const;

  const Source source_;
  std::mutex update_mutex_;  // of what follows
  bool stopped_ = false;
  std::set<std::string> missing_;  // robots of which a listener could not open
  Clock::time_point retry_;        // when they are opened again
  std::shared_ptr<const api::CellDescription> followed_;
  mutable std::mutex mutex_;  // of what follows; only those who hold both change it
  Robots robots_;
  std::string problem_;
};

}  // namespace aprsim::server
