#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "aprsim/v1/cell.pb.h"
#include "aprsim/v1/snapshot.pb.h"
#include "clients/ros2/dds/node.hpp"
#include "clients/ros2/trays/tray_finder.hpp"
#include "clients/wires/endpoints.hpp"

namespace aprsim::ros2 {

/// Publishes the trays that the cell's cameras see as NIST's aprs_vision does:
/// /AREA/SURFACE_trays_info of each camera that is named so, and in /tf the frames of trays and
/// slots in robots' areas, once a second. A camera looks only while somebody subscribes to its
/// topic. Thread: one. Errors of DDS: std::runtime_error.
class TrayPublisher {
 public:
  /// `ros_namespace`: before the names of topics, "/" = none. `frames`: writer of /tf.
  TrayPublisher(Node& node, std::string ros_namespace, dds_entity_t frames);
  ~TrayPublisher();
  TrayPublisher(const TrayPublisher&) = delete;
  TrayPublisher& operator=(const TrayPublisher&) = delete;

  /// The cell and its daemon from now on.
  void set_cell(const client::Endpoints& daemon, const v1::CellDescription& cell);
  /// The latest snapshot; begins and ends pictures as nodes subscribe and leave.
  void update(const v1::Snapshot& snapshot);

 private:
  class Area;

  /// The cell, and the poses of its latest snapshots. Thread: any.
  class Recent {
   public:
    void set_cell(std::shared_ptr<const v1::CellDescription> cell);
    [[nodiscard]] std::shared_ptr<const v1::CellDescription> cell() const;
    void add(const v1::Snapshot& snapshot);
    /// The poses nearest to a picture; without bodies if there are none of its epoch.
    [[nodiscard]] BodyPoses at(const v1::Image& image) const;

   private:
    mutable std::mutex mutex_;
    std::shared_ptr<const v1::CellDescription> cell_;
    std::deque<BodyPoses> poses_;
  };

  Node& node_;
  std::string namespace_;
  dds_entity_t frames_;
  Recent recent_;
  std::vector<std::unique_ptr<Area>> areas_;
};

}  // namespace aprsim::ros2
