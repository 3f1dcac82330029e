#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/trace/trace.hpp"
#include "clients/aprsim/trace/values.hpp"

/// What clients did on the wires of a run, without what differs from run to run: numbers of
/// commands, connections, transactions; polls.
namespace aprsim::trace {

/// A command, a write, a call; or, where the cell acts, an event.
struct Action {
  std::string kind;           ///< "MoveTo", "write speed", "InjectFault", "grasped"
  std::vector<Field> fields;  ///< what was asked for
  double time_s = 0;          ///< when it was sent
  /// Since the wire's action before has ended, or was sent where that had not ended.
  std::optional<double> pause_s;
  std::optional<double> duration_s;  ///< until its end was seen
  std::string outcome;               ///< "done", "an error", "no end", ...; empty = none was seen
  std::string words;                 ///< that came with the outcome; not compared
  std::vector<Field> results;        ///< how it ended
};

/// A thing as a camera sees it.
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
  std::size_t polls = 0;                     ///< what only asked
  std::map<std::string, std::size_t> reads;  ///< by what was asked for, where that can differ
  std::vector<Seen> seen;                    ///< in the end, by a camera
};

/// By listener, in the order of their names; events are the wire "events".
[[nodiscard]] std::map<std::string, WireActions> actions_of(const Trace& trace);

// ---- One kind of wire each; the records are all of one listener.
using Records = std::vector<const WireRecord*>;
[[nodiscard]] WireActions crcl_actions(const Records& records);
[[nodiscard]] WireActions modbus_actions(const Records& records);
[[nodiscard]] WireActions call_actions(const Records& records);
[[nodiscard]] WireActions vision_actions(const Records& records);

/// Fills in the pauses.
void add_pauses(std::vector<Action>& actions);

}  // namespace aprsim::trace
