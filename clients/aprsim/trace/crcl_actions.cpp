#include <algorithm>
#include <cctype>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "clients/aprsim/trace/action.hpp"
#include "clients/aprsim/trace/crcl_fields.hpp"
#include "crcl/command_codec.hpp"
#include "crcl/status_codec.hpp"

namespace aprsim::trace {
namespace {

/// A command without an observed end.
struct Waiting {
  std::size_t action = 0;  ///< its place among the actions
  bool seen_by_chance = false;
  bool is_new = true;
};

/// State of one connection.
struct Connection {
  crcl::Units units;
  std::map<std::int64_t, Waiting> waiting;  ///< by the id that was sent last
};

/// A status reports the latest command only. The end of a command without duration, or of a part
/// of a program, is seen only if a poll comes before the next one begins.
bool is_seen_by_chance(const crcl::CommandBody& body, bool in_program) {
  return in_program || !(std::holds_alternative<crcl::MoveTo>(body) ||
                         std::holds_alternative<crcl::MoveThroughTo>(body) ||
                         std::holds_alternative<crcl::MoveScrew>(body) ||
                         std::holds_alternative<crcl::ActuateJoints>(body) ||
                         std::holds_alternative<crcl::Dwell>(body));
}

/// Processes the commands and statuses of one robot.
class CrclReader {
 public:
  void take(const WireRecord& record) {
    Connection& connection = connections_[record.wire.connection()];
    const std::string& data = record.wire.data();
    if (record.wire.content() == v1::WIRE_CONTENT_RECEIVED) {
      if (data.find("<CRCLProgram") != std::string::npos) {
        program(record, connection);
      } else {
        command(record, connection);
      }
    } else if (record.wire.content() == v1::WIRE_CONTENT_SENT) {
      status(record, connection);
    }
  }

  WireActions take_result() {
    for (const auto& [number, connection] : connections_) {
      for (const auto& [id, waiting] : connection.waiting) {
        out_.actions[waiting.action].outcome = "no end";
      }
    }
    return std::move(out_);
  }

 private:
  void command(const WireRecord& record, Connection& connection) {
    const auto instance = crcl::decode_command(record.wire.data(), crcl::kMaxProgramBytes);
    if (!instance) {
      out_.actions.push_back({.kind = "unreadable command",
                              .fields = {{"error", instance.error().message()}},
                              .time_s = record.time_s,
                              .outcome = "refused"});
      return;
    }
    const crcl::Command& command = instance->command;
    if (std::holds_alternative<crcl::GetStatus>(command.body)) {
      ++out_.polls;
      return;
    }
    add(record, connection, command, false);
  }

  void add(const WireRecord& record, Connection& connection, const crcl::Command& command,
           bool in_program) {
    Waiting& waiting = connection.waiting[command.id];
    // Its end cannot be observed: another command reuses its id.
    if (!waiting.is_new) out_.actions[waiting.action].outcome = "no end";
    waiting = {out_.actions.size(), is_seen_by_chance(command.body, in_program), false};
    out_.actions.push_back({.kind = (in_program ? "program's " : "") + kind_of(command.body),
                            .fields = fields_of(command, connection.units),
                            .time_s = record.time_s});
    follow_units(command.body, connection.units);
  }

  void program(const WireRecord& record, Connection& connection) {
    const auto program = crcl::decode_program(record.wire.data());
    if (!program) {
      out_.actions.push_back({.kind = "unreadable program",
                              .fields = {{"error", program.error().message()}},
                              .time_s = record.time_s,
                              .outcome = "refused"});
      return;
    }
    for (const crcl::Command& command : program->commands) {
      add(record, connection, command, true);
    }
  }

  void status(const WireRecord& record, Connection& connection) {
    const std::string& data = record.wire.data();
    // Most statuses report a command in progress.
    if (connection.waiting.empty() || (data.find("CRCL_Done") == std::string::npos &&
                                       data.find("CRCL_Error") == std::string::npos)) {
      return;
    }
    const auto status = crcl::decode_status(data);
    if (!status) return;
    const auto at = connection.waiting.find(status->command.command_id);
    if (at == connection.waiting.end()) return;
    const std::size_t place = at->second.action;
    Action& action = out_.actions[place];
    connection.waiting.erase(at);
    std::erase_if(connection.waiting, [place](const auto& entry) {
      return entry.second.action < place && entry.second.seen_by_chance;
    });
    const bool done = status->command.state == crcl::CommandState::kDone;
    action.outcome = done ? "done" : "an error";
    action.duration_s = record.time_s - action.time_s;
    action.words = status->command.description.value_or("");
    // The position at which an error stops a robot is random.
    if (done) action.results = results_of(*status, connection.units);
  }

  std::map<std::uint64_t, Connection> connections_;
  WireActions out_;
};

}  // namespace

WireActions crcl_actions(const Records& records) {
  CrclReader reader;
  for (const WireRecord* record : records) reader.take(*record);
  return reader.take_result();
}

}  // namespace aprsim::trace
