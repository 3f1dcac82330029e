#include "server/replay/simple_message_states.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
#include <variant>

#include <fmt/format.h>

#include "protocols/simple_message/codec/message_codec.hpp"
#include "protocols/simple_message/controller_state.hpp"
#include "world/api/description/robot_identity.hpp"

namespace aprsim::server::journal {
namespace {

using namespace simple_message;

/// Steps between the snapshot of a state and that of its record.
constexpr std::uint64_t kLag = 100;

/// The joints of a state; nullopt for replies and statuses.
std::optional<Joints> joints_of(const std::string& bytes) {
  const std::span<const std::uint8_t> data(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                           bytes.size());
  const auto message = decode_reply(data, ByteOrder::kBig);
  if (!message || message->communication != Communication::kTopic) return std::nullopt;
  if (const auto* position = std::get_if<JointPosition>(&message->body)) return position->position;
  if (const auto* feedback = std::get_if<JointFeedback>(&message->body)) return feedback->position;
  return std::nullopt;
}

}  // namespace

std::optional<WireReply> SimpleMessageStates::sent(const std::string& message,
                                                   world::RunTime at) const {
  const auto then = joints_of(message);
  if (!then) return std::nullopt;
  world::RunTime from = at;
  from.step -= std::min(from.step, kLag);
  return WireReply{
      from, at, [then = *then, robot = robot_, kind = controller_](const api::Snapshot& snapshot) {
        const std::size_t count = kind == ControllerKind::kFanucKarel ? 6 : 7;
        const auto index = api::robot_named(*snapshot.cell, robot);
        if (!index) return missing_robot(robot);
        std::vector<double> joints;
        for (std::size_t i = 0; i < count; ++i) {
          joints.push_back(snapshot.robots.at(*index).joints.at(i).position_rad);
        }
        const Joints here = measured_to_wire(kind, joints);
        Deviation all;
        for (std::size_t i = 0; i < count; ++i) {
          all.number(fmt::format("position of joint {}", i + 1), then[i], here[i]);
        }
        return all;
      }};
}

}  // namespace aprsim::server::journal
