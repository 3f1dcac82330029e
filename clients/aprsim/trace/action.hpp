#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/trace/trace.hpp"
#include "clients/aprsim/trace/values.hpp"

/// Actions of clients on the wires of a run, without polls and without the numbers of commands,
/// connections and transactions, which differ from run to run.
namespace aprsim::trace {

/// A command, a write, a call, or an event of the cell.
struct Action {
  std::string kind;           ///< "MoveTo", "write speed", "InjectFault", "grasped"
  std::vector<Field> fields;  ///< of the request
  double time_s = 0;          ///< of sending
  /// Pause since the end of the previous action, or since its sending if it had not ended.
  std::optional<double> pause_s;
  std::optional<double> duration_s;  ///< until its end was observed
  std::string outcome;               ///< "done", "an error", "no end", ...; empty = none was seen
  std::string words;                 ///< message with the outcome; not compared
  std::vector<Field> results;        ///< reported with the end
};

/// An object that a camera sees.
struct Seen {
  std::string name, type;  ///< type: P part, PT part tray, KT kit tray
  double x_mm = 0, y_mm = 0;
  double rotation_rad = 0;
};

/// One listener of a run.
struct WireActions {
  std::string name;  ///< as in the ports file: "crcl.fanuc"
  v1::WireKind kind = v1::WIRE_KIND_UNSPECIFIED;
  std::vector<Action> actions;
  std::size_t polls = 0;                     ///< requests without effect
  std::map<std::string, std::size_t> reads;  ///< register ranges with their number of reads
  std::vector<Seen> seen;                    ///< final objects of a camera
};

/// Actions by listener, in the order of their names; events have the listener "events".
[[nodiscard]] std::map<std::string, WireActions> actions_of(const Trace& trace);

// ---- One function per kind of wire; all records belong to one listener.
using Records = std::vector<const WireRecord*>;
[[nodiscard]] WireActions crcl_actions(const Records& records);
[[nodiscard]] WireActions modbus_actions(const Records& records);
[[nodiscard]] WireActions simple_message_actions(const Records& records);
[[nodiscard]] WireActions call_actions(const Records& records);
[[nodiscard]] WireActions vision_actions(const Records& records);

/// Fills in the pauses.
void add_pauses(std::vector<Action>& actions);

}  // namespace aprsim::trace
