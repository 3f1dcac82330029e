#include "clients/aprsim/commands/manual.hpp"

#include <array>
#include <ostream>
#include <string_view>

#include <fmt/format.h>

#include "clients/aprsim/cli/command_tree.hpp"
#include "clients/aprsim/cli/exit_code.hpp"

namespace aprsim::client {
namespace {

constexpr std::string_view kDate = "November 22, 2026";  // of the text below

struct Entry {
  std::string_view name, text;
};

constexpr std::array kEnvironment{
    Entry{"APRSIM_PORTS_FILE", "File of ports to use when --ports-file names none."},
    Entry{"APRSIM_TOKEN", "The daemon's access token when --token-file names no file of it."},
    Entry{"APRSIM_CA", "Authorities of the daemon's certificate when --ca names no file of them."},
    Entry{"APRSIM_CERTIFICATE",
          "This client's certificate when --certificate names no file of it."},
    Entry{"APRSIM_KEY", "Its key when --key names no file of it."},
    Entry{"NO_COLOR", "When set and not empty, nothing is coloured."},
    Entry{"TERM", "When dumb or not set, output is not coloured and not redrawn in place."},
};

// Keys of the objects of --json, by command.
constexpr std::array kJson{
    Entry{"status",
          "The snapshot as protobuf's JSON mapping of aprsim.v1.Snapshot gives it, with "
          "the names of its .proto file."},
    Entry{"watch", "The same of aprsim.v1.StreamSnapshotsResponse, one object a sample."},
    Entry{"events",
          "sequence, epoch, step, sim_time_s, kind, names (list), text, robot (its number, from 0, "
          "or null), number (of the command or fault, 0: none), lost (events before it that are "
          "not kept any more): one object an event."},
    Entry{"states list",
          "states (list of name, step, sim_time_s, bytes), bytes and max_bytes: of all together."},
    Entry{"states delete", "done (states delete), name."},
    Entry{"incident", "done (incident), file, bytes."},
    Entry{"pause, resume, step, run, speed, reset, save, load, intruder, device set",
          "done (the command), step, sim_time_s, epoch: when it took effect; save with --file also "
          "file and bytes; load also name; run also met (its condition holds); intruder also "
          "light_curtain (broken or clear), where "
          "there is one; device set also device, signal, value."},
    Entry{
        "replay",
        "run_id, scene, seed, cautions (list of why bits may differ), steps, commands, compared "
        "(states), gaps, missing (records), damage, same, difference (null, or epoch, step, text), "
        "replies (compared), reply (the first that is another one: null, or as difference)."},
    Entry{"scene show, list, types",
          "name, revision, text; name, type, at_m (list), lost: one object a body; type: one "
          "object a type."},
    Entry{"scene spawn, move, remove, set",
          "done (the command), step, sim_time_s, epoch: when it took effect; name, at_m of bodies; "
          "path, value."},
    Entry{"fault list",
          "faults (list of id, kind, target, parameters, trigger, state (pending, active, ended), "
          "begin_step, end_step, note)."},
    Entry{"fault kinds",
          "name, target, momentary, meaning, parameters (list of name, unit, min, max, default, "
          "meaning): one object a kind."},
    Entry{"fault inject, end, event",
          "done (the command), step, sim_time_s, epoch: when it took effect; inject also id and "
          "fault, as in the list; end also id; event also event."},
    Entry{"scenario list, check",
          "name and description; name, file, scene, kits, faults, time_limit_s."},
    Entry{
        "scenario run",
        "scenario, description, seed, controller, end_reason, state_hash (of the cell then; only "
        "in virtual time), as_expected, measures (by name, null if not measured), "
        "expected (list of measure, value, min, max, kept), kits, placements, collisions, faults, "
        "robots, events (lists). With --progress also, as it happens, time_s and event; and "
        "progress "
        "(time_s, placed, orders: a list of name, tray, state, kits, done, parts, parts_wanted); "
        "without --json its last line is report, the table."},
    Entry{
        "scene check, scenario check",
        "for each problem file, line, column, severity (error or warning), key, message; for each "
        "valid scene valid (its file), robots, trays, gears, parts (their numbers)."},
    Entry{"scene diff, scenario diff",
          "same, before, after (files), differences (list of change: added, removed, moved or "
          "changed; key, before, after, unit, and moved_m if it is moved)."},
    Entry{
        "batch, merge",
        "scenario, description, controller, version, fingerprint, runs, missing (seeds), "
        "as_expected, as_expected_share_95 (confidence interval), measures (by name: unit, "
        "better (higher, lower or empty), runs, mean, mean_95, deviation, min, p05, median, p95, "
        "max), success_by_parameter (by name: list of "
        "from, to, runs, as_expected, share_95), sensitivity (list of parameter, outcome, "
        "rank_correlation, p, p_adjusted), worst (list of seed, why, journal: runs that failed or "
        "deviate), journals (list of seed, journal); report.json also "
        "has episodes: list of seed, as_expected, end_reason, state_hash, broken, values, drawn. "
        "batch "
        "also run_now, wall_s, repeated_attempts, peak_world_mb."},
    Entry{
        "report diff",
        "runs_before, runs_after, paired, pairs, level, worse, outcomes (list of outcome, before, "
        "after, p, p_adjusted, change: better, worse, different or empty)."},
    Entry{"calibrate",
          "scene, estimates (list of name, value, low, high: the 95 % interval, unit, key of the "
          "scene or null, scene_value or null, told, why_not or null, samples), notes."},
    Entry{"compare",
          "scene, differences (list of part, quantity, unit, limit, rms, most, at_s, samples), "
          "parameters (as the estimates of calibrate), beyond (list of texts), notes."},
    Entry{
        "trace diff",
        "same, a and b (place, run_id, scene, version), tolerance (by name), first (null or a "
        "deviation), worst (list of at most 10), wires (list of name, actions_a, actions_b, "
        "compared, deviations, polls_a, polls_b), notes, deviations (list of wire, kind (missing, "
        "extra, order, value, outcome, result, duration, pause, read, seen, wire), command_a and "
        "command_b (numbers on the wire, or null), command, time_s, field, a, b, difference, "
        "tolerance, times_tolerance (SI, null where nothing is measured), text)."},
    Entry{
        "trace export",
        "written (csv, mcap or html), to, snapshots, wires, events, messages: one object for each "
        "thing written."},
    Entry{"trace import",
          "journal, packets, skipped (packets of an unsupported encapsulation), connections, "
          "records, duration_s, by_listener (documents, units and lines of each), notes (what is "
          "missing)."},
    Entry{"trace show",
          "time_s, wire, connection, direction (in, out or empty), text: one object a line; notes "
          "at the end, where something is missing."},
    Entry{"crcl status, init, stop, gripper, jog, send, run",
          "robot, command_id, command, state (CRCL_Done, ...), description, program_index, "
          "program_length, tool (its point), x_axis, z_axis, joints, gripper (separation of the "
          "fingers), holding: one object a status, null where the robot does not say; lengths and "
          "angles in the units of a new connection, millimetres and degrees by default."},
    Entry{"crcl validate", "file, valid_documents."},
    Entry{"conveyor status",
          "drive (absent, standstill, ramping, at speed, fault), run, forward, speed_setting_m_s, "
          "speed_m_s, target_speed_m_s, max_speed_m_s, travel_m, sim_time_s, ready, fault (none, "
          "...), emergency_stop, motor_current_a, load_kg, photo_eyes (list of broken, count), "
          "light_curtain (null, or broken, beams, range_m)."},
    Entry{"conveyor set", "register, address, value: one object for each register written."},
    Entry{"conveyor map",
          "area, address, name, values (so many, one after the other), writable, encoding, unit, "
          "unit_per_count, min, max (in counts), meaning: one object a register."},
    Entry{"modbus map",
          "server, area, address, signal, writable, encoding, word_order, scale, offset, unit, "
          "meaning: one object a register."},
    Entry{"conform crcl, modbus",
          "clause, source, check, expected, seen, verdict (pass, fail, not checked): one object a "
          "rule; last host, port, passed, failed, not_checked, groups."},
    Entry{"demo",
          "source (a robot, belt or demo), action, and its data: gear, from, to, tray, place, "
          "reason, yaw_rad, force_N, separation_m, lift_m, slip_m, off_m, distance_m, travel_m, "
          "tray_m. The actions are transfer, over, holds, lifted, carried, refused, puts_back, "
          "rests, "
          "out_of_reach; brings, stopped, nothing_to_bring; done."},
};

constexpr std::array kExamples{
    Entry{"aprsim status", "The cell as it is now."},
    Entry{"aprsim crcl jog --robot fanuc --init --axis z --by 20", "20 mm up."},
    Entry{"aprsim crcl stop", "Both robots stop."},
    Entry{"aprsim events --kind grasped --kind released",
          "Shows grasps and releases of the robots."},
    Entry{"aprsim fault inject gripper-leak fanuc --over 5 --when grasp:fanuc:2",
          "Weakens the gripper from its second grasp on."},
    Entry{"aprsim conveyor set --speed 50% --direction reverse", "Runs the belt in reverse."},
    Entry{"aprsim --ca ca.pem --certificate me.pem --key me.key conveyor status --secure",
          "Shows the belt over Modbus Security."},
    Entry{"aprsim conveyor status --json | jq .speed_m_s", "Prints the speed of the belt."},
};

/// Escapes text for mdoc: no macros, no escapes, hyphens that can be copied. A line may break after
/// a bar, so that long lists of values fit.
std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '|') {
      out += "|\\:";
    } else {
      out += c;
    }
  }
  return out.starts_with('.') || out.starts_with('\'') ? "\\&" + out : out;
}

/// Sentences, each on a line of its own for mdoc.
std::string sentences(std::string_view text) {
  std::string out = plain(text);
  for (std::size_t at = 0; (at = out.find(". ", at)) != std::string::npos; ++at) out[at + 1] = '\n';
  return out;
}

/// One argument of a macro, which may contain blanks.
std::string argument(std::string_view text) { return "\"" + plain(text) + "\""; }

std::string option_line(const OptionInfo& option) {
  std::string out = ".It";
  for (const auto& name : option.names) {
    out += fmt::format("{} Fl {}", out == ".It" ? "" : " ,", plain(name.substr(1)));
  }
  return option.value.empty() ? out : fmt::format("{} Ar {}", out, argument(option.value));
}

void add_options(const CommandInfo& command, std::string& out) {
  if (command.options.empty()) return;
  out += ".Bl -tag -width Ds -compact\n";
  for (const auto& option : command.options) {
    out += option_line(option) + "\n" + sentences(option.help) +
           (option.required ? " (required)" : "") + ".\n";
  }
  out += ".El\n";
}

void add_command(const CommandInfo& command, const std::string& program, std::string& out) {
  if (command.commands.empty()) {
    out += fmt::format(".It Cm {}", argument(command.path.substr(program.size() + 1)));
    for (const auto& option : command.options) {
      if (option.positional) out += " Ar " + argument(option.value);
    }
    out += "\n" + sentences(command.help) + ".\n";
    add_options(command, out);
  }
  for (const auto& sub : command.commands) add_command(sub, program, out);
}

template <typename Entries>
void add_list(const Entries& entries, const char* macro, std::string& out) {
  out += ".Bl -tag -width Ds\n";
  for (const auto& entry : entries) {
    out += fmt::format(".It {} {}\n{}\n", macro, argument(entry.name), sentences(entry.text));
  }
  out += ".El\n";
}

}  // namespace

std::string manual_page() {
  const CommandInfo program = command_tree();
  std::string out = fmt::format(
      ".Dd {}\n.Dt APRSIM 1\n.Os \"aprsim {}\"\n.Sh NAME\n.Nm aprsim\n"
      ".Nd client of the simulated kitting cell aprsimd\n"
      ".Sh SYNOPSIS\n.Nm\n.Op Ar option ...\n.Ar command\n.Op Ar argument ...\n"
      ".Sh DESCRIPTION\n.Nm\nqueries and commands a running\n.Xr aprsimd 1 ,\n"
      "over the wires that the cell has: CRCL for the robots, Modbus for the belt, gRPC for the\n"
      "rest.\nResults go to standard output, what is wrong to standard error.\n.Pp\n"
      "The following options say where the daemon is, and may stand before or after the command:\n"
      ".Pp\n",
      kDate, APRSIM_VERSION);
  add_options(program, out);
  out += ".Sh COMMANDS\n.Bl -tag -width Ds\n";
  add_command(program, program.path, out);
  out +=
      ".El\n.Sh JSON OUTPUT\n"
      "With\n.Fl \\-json\neach result is an object on a line of its own.\nNumbers are in SI units, "
      "or in those that their name says.\nFailures stay "
      "text\n"
      "on standard error; the exit status tells their kind.\n";
  add_list(kJson, "Cm", out);
  out += ".Sh ENVIRONMENT\n";
  add_list(kEnvironment, "Ev", out);
  out += ".Sh EXIT STATUS\n.Bl -tag -width Ds\n";
  for (const auto& exit : kExitCodes) {
    out += fmt::format(".It {}\n{}.\n", exit.code, plain(exit.meaning));
  }
  out += ".El\n.Sh EXAMPLES\n.Bl -tag -width Ds\n";
  for (const auto& example : kExamples) {
    out += fmt::format(".It Li {}\n{}\n", argument(example.name), sentences(example.text));
  }
  return out + ".El\n.Sh SEE ALSO\n.Lk https://no-color.org\n";
}

}  // namespace aprsim::client
