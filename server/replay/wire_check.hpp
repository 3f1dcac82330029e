#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "aprsim/v1/journal.pb.h"
#include "modbus/register_map.hpp"
#include "server/replay/crcl_replies.hpp"
#include "server/replay/difference.hpp"
#include "server/replay/modbus_replies.hpp"
#include "server/replay/simple_message_states.hpp"
#include "server/replay/vision_lines.hpp"
#include "server/replay/wire_moments.hpp"
#include "server/replay/wire_reply.hpp"
#include "world/cell/world.hpp"
#include "world/runtime/record/recorder.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server::journal {

/// Compares the recorded replies of listeners with those of the replay, as far as the cell alone
/// determines them: joints, poses and grippers of CRCL statuses, joints of Simple Messages,
/// registers read by Modbus clients, lines of cameras. Thread: one at a time.
class WireCheck {
 public:
  /// `scaling`: of the recorded run's belt; absent = replies of its PLC are not compared.
  WireCheck(const scene::Scene& scene, const std::optional<modbus::ConveyorScaling>& scaling);

  /// Processes each record in order, before it is replayed; `runs`: whether it is.
  void process(const v1::JournalRecord& record, bool runs);
  /// As Replay::Watch.
  void observe(const world::World& world, world::RunTime time);
  /// Compares the rest at the end of the run.
  void finish();

  /// Number of compared replies.
  [[nodiscard]] std::uint64_t compared() const { return compared_; }
  /// The first reply that differs.
  [[nodiscard]] const std::optional<Difference>& difference() const { return difference_; }

 private:
  struct Connection {
    std::string name;                    ///< listener and peer
    std::optional<std::string> robot{};  ///< whose camera it is
    std::shared_ptr<CrclReplies> crcl{};
    std::shared_ptr<ModbusReplies> modbus{};
    std::shared_ptr<const SimpleMessageStates> states{};
    bool known_line = false;  ///< of its camera, before
  };
  struct Waiting {
    WireReply reply;
    std::string name;  ///< of its connection
  };
  struct WaitingLine {
    world::RunTime at;
    std::shared_ptr<Connection> connection;
    std::string line;
  };

  void learn(const scene::Scene& scene);
  void process(const v1::JournalWire& wire, bool runs);
  [[nodiscard]] Connection& connection_of(const v1::JournalWire& wire);
  void compare(bool ended);
  void compare(const Waiting& waiting);
  void compare(const WaitingLine& line);
  void differs(world::RunTime time, const std::string& name, const std::string& what);

  std::shared_ptr<const scene::Scene> scene_;                          ///< of the latest moment
  std::map<std::string, simple_message::ControllerKind> controllers_;  ///< by robot
  const std::optional<modbus::ConveyorScaling> scaling_;
  std::map<std::uint64_t, std::shared_ptr<Connection>> connections_;  ///< by number
  std::deque<Waiting> waiting_;
  std::deque<WaitingLine> lines_;
  bool stopped_ = false;  ///< the recorded simulation has stopped
  api::Snapshot now_;
  WireMoments moments_;
  VisionLines vision_;
  std::uint64_t compared_ = 0;
  std::optional<Difference> difference_;
};

}  // namespace aprsim::server::journal
