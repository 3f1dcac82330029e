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

/// What is known of one connection.
struct Connection {
  crcl::Units units;
  /// The command of each id that was sent last and whose end is not seen yet: its place among the
  /// actions.
  std::map<std::int64_t, std::size_t> waiting;
};

/// Goes through what one robot was sent and answered.
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
    for (Action& action : out_.actions) {
      if (action.outcome.empty()) action.outcome = "no end";
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
    connection.waiting[command.id] = out_.actions.size();
    out_.actions.push_back({.kind = kind_of(command.body),
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
      connection.waiting[command.id] = out_.actions.size();
      out_.actions.push_back({.kind = "program's " + kind_of(command.body),
                              .fields = fields_of(command, connection.units),
                              .time_s = record.time_s});
      follow_units(command.body, connection.units);
    }
  }

  void status(const WireRecord& record, Connection& connection) {
    const std::string& data = record.wire.data();
    // Most of them tell of a command that is under way.
    if (connection.waiting.empty() || (data.find("CRCL_Done") == std::string::npos &&
                                       data.find("CRCL_Error") == std::string::npos)) {
      return;
    }
    const auto status = crcl::decode_status(data);
    if (!status) return;
    const auto at = connection.waiting.find(status->command.command_id);
    if (at == connection.waiting.end()) return;
    Action& action = out_.actions[at->second];
    connection.waiting.erase(at);
    const bool done = status->command.state == crcl::CommandState::kDone;
    action.outcome = done ? "done" : "an error";
    action.duration_s = record.time_s - action.time_s;
    action.words = status->command.description.value_or("");
    // Where an error stops a robot is chance.
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
