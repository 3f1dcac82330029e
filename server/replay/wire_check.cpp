#include "server/replay/wire_check.hpp"

#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace aprsim::server::journal {

WireCheck::WireCheck(const scene::Scene& scene,
                     const std::optional<modbus::ConveyorScaling>& scaling)
    : scaling_(scaling) {
  learn(scene);
}

/// Connections of robots that have gone may be compared after that.
void WireCheck::learn(const scene::Scene& scene) {
  for (const scene::Robot& robot : scene.robots) {
    controllers_.erase(robot.name);
    if (!robot.simple_message) continue;
    controllers_[robot.name] =
        robot.simple_message->controller == scene::SimpleMessageController::kMotomanFs100
            ? simple_message::ControllerKind::kMotomanFs100
            : simple_message::ControllerKind::kFanucKarel;
  }
}

void WireCheck::process(const v1::JournalRecord& record, bool runs) {
  if (difference_) return;
  if (record.has_wire()) {
    process(record.wire(), runs && !stopped_);
  } else if (record.has_gap() && record.gap().records() > 0) {
    // Missing records may include requests and opened connections.
    connections_.clear();
    waiting_.clear();
    lines_.clear();
  } else if (record.has_epoch()) {
    stopped_ = false;
  } else if (record.has_event() && record.event().kind() == v1::CELL_EVENT_KIND_WORLD_STOPPED) {
    stopped_ = true;  // listeners report this fault, a replay does not have it
  }
}

WireCheck::Connection& WireCheck::connection_of(const v1::JournalWire& wire) {
  auto& connection = connections_[wire.connection()];
  if (connection) return *connection;
  connection = std::make_shared<Connection>();
  connection->name = wire.listener() + " to " + wire.peer();
  const auto dot = wire.listener().find('.');
  const std::string robot = wire.listener().substr(dot == std::string::npos ? 0 : dot + 1);
  if (wire.kind() == v1::WIRE_KIND_VISION) connection->robot = robot;
  if (wire.kind() == v1::WIRE_KIND_CRCL) {
    connection->crcl = std::make_shared<CrclReplies>(robot);
  } else if ((wire.listener() == "modbus" || wire.listener() == "modbus_tls") && scaling_) {
    connection->modbus = std::make_shared<ModbusReplies>(conveyor_deviation(*scaling_));
  } else if (wire.kind() == v1::WIRE_KIND_MODBUS && dot != std::string::npos) {
    const std::string server = wire.listener().substr(dot + 1);
    connection->modbus = std::make_shared<ModbusReplies>(map_deviation(server));
  } else if (wire.kind() == v1::WIRE_KIND_SIMPLE_MESSAGE && controllers_.contains(robot)) {
    connection->states = std::make_shared<SimpleMessageStates>(robot, controllers_.at(robot));
  }
  return *connection;
}

void WireCheck::process(const v1::JournalWire& wire, bool runs) {
  const world::RunTime at{wire.time().epoch(), wire.time().step()};
  if (wire.content() == v1::WIRE_CONTENT_CLOSED) {
    connections_.erase(wire.connection());
    return;
  }
  Connection& connection = connection_of(wire);
  const bool received = wire.content() == v1::WIRE_CONTENT_RECEIVED;
  if (!received && wire.content() != v1::WIRE_CONTENT_SENT) return;
  std::optional<WireReply> reply;
  if (connection.crcl) {
    if (received) return connection.crcl->received(wire.data(), at);
    reply = connection.crcl->sent(wire.data(), at);
  } else if (connection.modbus) {
    if (received) return connection.modbus->received(wire.data(), at);
    reply = connection.modbus->sent(wire.data(), at);
  } else if (connection.states && !received) {
    reply = connection.states->sent(wire.data(), at);
  } else if (wire.kind() == v1::WIRE_KIND_VISION && connection.robot && !received && runs) {
    lines_.push_back({at, connections_[wire.connection()], wire.data()});
  }
  if (reply && runs) waiting_.push_back({*std::move(reply), connection.name});
}

void WireCheck::observe(const world::World& world, world::RunTime time) {
  if (difference_) return;
  compare(false);
  if (world.scene() != scene_) {
    scene_ = world.scene();
    learn(*scene_);
  }
  world.write(now_);
  now_.epoch = time.epoch;
  if (!moments_.add(time, now_) && time.step > 0) vision_.begin_late();
  vision_.add(now_);
}

void WireCheck::finish() { compare(true); }

/// Compares the replies of past moments.
void WireCheck::compare(bool ended) {
  if (moments_.empty()) return;
  const auto over = [&](world::RunTime time) { return ended || time < moments_.now(); };
  for (; !waiting_.empty() && over(waiting_.front().reply.to); waiting_.pop_front()) {
    compare(waiting_.front());
  }
  for (; !lines_.empty() && over(lines_.front().at); lines_.pop_front()) compare(lines_.front());
}

void WireCheck::compare(const Waiting& waiting) {
  const WireReply& reply = waiting.reply;
  std::optional<Deviation> least;
  moments_.each_back(reply.from, reply.to, [&](const api::Snapshot& snapshot) {
    Deviation found = reply.deviation(snapshot);
    if (!least || found.size() < least->size()) least = std::move(found);
    return least->any();
  });
  if (!least || (least->any() && !moments_.covers(reply.from, reply.to))) return;
  ++compared_;
  if (least->any()) differs(reply.to, waiting.name, least->text());
}

void WireCheck::compare(const WaitingLine& line) {
  Connection& connection = *line.connection;
  const bool known = vision_.has(*connection.robot, line.line);
  // The line may be older than the beginning of the replay.
  const bool may_be_old = !vision_.whole() && !connection.known_line;
  const bool here = line.at <= moments_.now();
  if (known) connection.known_line = true;
  if (!here || (!known && may_be_old)) return;
  ++compared_;
  if (!known)
    differs(line.at, connection.name, "a line that the camera does not send in the replay");
}

void WireCheck::differs(world::RunTime time, const std::string& name, const std::string& what) {
  if (!difference_ || time < difference_->time) difference_ = {time, name + ": " + what};
}

}  // namespace aprsim::server::journal
