#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "protocols/conveyor/conveyor_device.hpp"
#include "protocols/ports/program_runner.hpp"
#include "protocols/record/wire_tap.hpp"
#include "protocols/web/topics/fault_log.hpp"
#include "protocols/web/topics/listener_count.hpp"
#include "protocols/web/topics/scene_appearance.hpp"
#include "protocols/web/topics/topic.hpp"
#include "world/api/ports/history.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::web {

/// Status where no programs can be started.
[[nodiscard]] std::shared_ptr<const ProgramStatus> no_programs();

/// Sources of all topics. The objects must outlive the topics; null = absent.
struct TopicSources {
  std::string instance_id;
  int beams = 0;                     ///< of the light curtain
  api::SnapshotPtr now;              ///< snapshot of the tick; set before each one
  const FaultLog* faults;            ///< never null
  conveyor::ConveyorDevice* device;  ///< never null
  api::History* history = nullptr;
  ProgramRunner* programs = nullptr;
  protocols::WireTap* crcl_tap = nullptr;
  protocols::WireTap* modbus_tap = nullptr;
  SceneAppearance::Describe visual;
  std::function<std::vector<ListenerCount>()> listeners;
  std::function<void()> on_skipped_snapshot;
};

/// All topics in the order of sending. They refer to the sources.
[[nodiscard]] std::vector<Topic> all_topics(const TopicSources& sources);

}  // namespace aprsim::web
