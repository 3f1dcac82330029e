#pragma once

#include "server/config/config.hpp"
#include "server/config/config_types.hpp"

/// The keys of the configuration: each stands here once, with its value, type and meaning, in the
/// order in which they are read and printed. An archive, in the sense of Drake's Serialize, goes
/// over them to read, print or list them. It has
///   key(name, value, type, meaning)            one value,
///   by_robot(name, values, type, meaning)      the same for each robot, by its name,
///   section(name, part, meaning)               a map of keys,
///   section_by_robot(name, parts, common, meaning)  the same for each robot; `common` holds for
///                                              what a robot leaves out,
///   require(truth, expected)                   what must hold between the keys so far.
namespace aprsim::server {

inline constexpr Whole kConnections{1, 1024};
inline constexpr std::int64_t kDay = 86'400'000;  // [ms]
inline constexpr const char* kAllowed =
    "who is served besides this machine; nobody when empty, everybody by 0.0.0.0/0 and ::/0";

template <typename Archive>
void visit(Archive& keys, CrclRobotConfig& robot) {
  keys.key("length_unit", robot.length_unit, Word{{"meter", "millimeter", "inch"}},
           "length unit of a new socket");
  keys.key("angle_unit", robot.angle_unit, Word{{"degree", "radian"}},
           "angle unit of a new socket");
  keys.key("validation", robot.strict, Word{{"lenient", "strict"}},
           "strict refuses what the schema does not allow");
  keys.key("out_of_range", robot.clamp_targets, Word{{"refuse", "clamp"}},
           "clamp moves targets beyond the limits onto them");
  // As in the cell: a robot goes on with what it has taken when a socket closes.
  keys.key("end_program_with_client", robot.end_program_with_client, Flag{},
           "whether an uploaded program ends when the client that sent it disconnects");
  keys.key("cartesian_min_m", robot.cartesian_min_m, Maybe<Point>{},
           "lower corner of where the tool point may be sent, in the robot's reference frame; its "
           "reach without");
  keys.key("cartesian_max_m", robot.cartesian_max_m, Maybe<Point>{}, "upper corner of it");
  for (std::size_t i = 0; i < 3 && robot.cartesian_min_m && robot.cartesian_max_m; ++i) {
    keys.require((*robot.cartesian_min_m)[i] < (*robot.cartesian_max_m)[i],
                 "cartesian_min_m below cartesian_max_m on every axis");
  }
}

template <typename Archive>
void visit(Archive& keys, CrclConfig& crcl) {
  keys.key("address", crcl.address, Text{}, "address to listen on");
  keys.by_robot("ports", crcl.ports, Port{}, "port of a robot; a free one for a robot without");
  keys.key("max_connections", crcl.max_connections, kConnections, "at once, to each robot");
  keys.key("allow", crcl.allow, ListOf<Network>{}, kAllowed);
  keys.key("document_timeout_ms", crcl.document_timeout_ms, Whole{10, kDay},
           "for a document to arrive from its first byte on");
  keys.key("idle_timeout_ms", crcl.idle_timeout_ms, Whole{0, kDay},
           "a connection that has sent nothing for so long is closed; 0 = never");
  visit(keys, crcl.all);
  keys.section_by_robot("robots", crcl.robots, crcl.all, "what differs for one robot");
}

template <typename Archive>
void visit(Archive& keys, ModbusConfig& modbus) {
  keys.key("address", modbus.address, Text{}, "address to listen on");
  keys.key("port", modbus.port, Port{}, "port to listen on");
  keys.key("max_connections", modbus.max_connections, kConnections, "at once");
  keys.key("forward_is_one", modbus.forward_is_one, Flag{},
           "whether 1 in register 0x8001 means forward");
  keys.key("full_scale_m_s", modbus.full_scale_m_s, Number{yaml::kPositive},
           "belt speed that 32768 in register 0x8002 stands for");
  keys.key("allow", modbus.allow, ListOf<Network>{}, kAllowed);
  keys.key("unit_ids", modbus.unit_ids, ListOf<Whole>{{0, 255}},
           "unit ids that are ours; any when empty");
  keys.key("read_only", modbus.read_only, Flag{}, "refuse the functions that write");
  keys.key("max_requests_per_s", modbus.max_requests_per_s, RateLimit{}, "of one connection");
  keys.key("request_timeout_ms", modbus.request_timeout_ms, Whole{10, kDay},
           "for a request to arrive, and for a reply to be taken");
  keys.key("idle_timeout_ms", modbus.idle_timeout_ms, Whole{0, kDay},
           "a connection without a request for so long is closed; 0 = never");
  keys.key("watchdog_ms", modbus.watchdog_ms, Whole{0, kDay},
           "simulated time without a write after which the belt stops; 0 = never");
}

template <typename Archive>
void visit(Archive& keys, GrpcConfig& grpc) {
  keys.key("address", grpc.address, Text{}, "address to listen on");
  keys.key("port", grpc.port, Port{}, "port to listen on");
  keys.key("max_connections", grpc.max_connections, kConnections, "at once");
}

template <typename Archive>
void visit(Archive& keys, VisionConfig& vision) {
  keys.key("address", vision.address, Text{}, "address to listen on");
  keys.by_robot("ports", vision.ports, Port{},
                "port of a robot's camera; a free one for a robot without");
  keys.key("max_connections", vision.max_connections, kConnections, "at once, to each camera");
  keys.key("allow", vision.allow, ListOf<Network>{}, kAllowed);
  keys.key("empty_slots", vision.empty_slots, Flag{}, "lines name what was not detected, too");
  // A frame at least every half second, as simulated cameras of APRS send; more often than a poll
  // makes no sense.
  keys.key("repeat_s", vision.repeat_s, Number{yaml::between(0.01, 0.5)},
           "wall time after which a frame without successor is sent again");
}

template <typename Archive>
void visit(Archive& keys, WebConfig& web) {
  keys.key("enabled", web.enabled, Flag{}, "serve the page");
  keys.key("address", web.address, Text{}, "address to listen on");
  keys.key("port", web.port, Port{}, "port to listen on");
  keys.key("max_connections", web.max_connections, kConnections, "at once");
  keys.key("max_viewers", web.max_viewers, kConnections, "pages that show the cell at once");
  keys.key("max_rate_hz", web.max_rate_hz, Number{yaml::between(1, 60)},
           "states of the cell that a page gets a second");
  keys.key("control", web.control, Flag{},
           "whether pages may command; false asks for credentials over gRPC, too");
  keys.key("token", web.token, Secret{8},
           "a token of the role admin besides those of access.file, for the page and gRPC");
  keys.key("token_file", web.token_file, Maybe<Text>{}, "file whose first line is the token");
  keys.key("hosts", web.hosts, ListOf<Text>{},
           "names of this machine in addresses, besides localhost");
  keys.key("programs", web.programs, Maybe<Flag>{},
           "whether pages that may command may start the kitting controller and scenarios, as "
           "programs beside the daemon; without it those of an address of this machine alone");
  keys.require(!web.programs.value_or(false) || web.control,
               "control: true beside programs: true, for whoever starts a program commands");
}

template <typename Archive>
void visit(Archive& keys, ConnectionsConfig& connections) {
  keys.key("per_address", connections.per_address, kConnections,
           "at once from one address to one listener; this machine's own may have all");
  keys.key("yield_after_ms", connections.yield_after_ms, Whole{0, kDay},
           "a connection without a request for so long is closed when a newcomer needs its place");
}

template <typename Archive>
void visit(Archive& keys, AccessConfig& access) {
  keys.key("file", access.file, Maybe<Text>{},
           "file of tokens and of names in client certificates with their roles, made by aprsimd "
           "token; of mode 600");
  keys.key("anonymous", access.strangers_look, Word{{"none", "view"}},
           "role over gRPC and on the page of who has no credentials, on this machine only where "
           "credentials are asked for");
  keys.key("insecure_control", access.insecure_control, Flag{},
           "whether who has no credentials may do everything, also from other machines");
  keys.key("allow_foreign_states", access.allow_foreign_states, Flag{},
           "whether saved states are loaded that no daemon of this user has signed");
  keys.key("audit_file", access.audit_file, Maybe<Text>{},
           "file to which every command is appended with who sent it, as JSON lines");
  keys.require(!access.insecure_control || access.strangers_look,
               "anonymous: view beside insecure_control: true");
}

template <typename Archive>
void visit(Archive& keys, TlsConfig& tls) {
  keys.key("certificate", tls.certificate, Maybe<Text>{},
           "PEM file of the certificate with which gRPC and the page are encrypted; without they "
           "are not");
  keys.key("key", tls.key, Maybe<Text>{}, "PEM file of its private key, without a password");
  keys.key("client_ca", tls.client_ca, Maybe<Text>{},
           "PEM file of the authorities whose certificates clients may show");
  keys.key("client_certificates", tls.client_needed, Word{{"optional", "required"}},
           "required: who shows no certificate of these authorities is not served");
  keys.require(tls.certificate.has_value() == tls.key.has_value(), "both certificate and key");
  keys.require(tls.certificate || !tls.client_ca, "certificate and key beside client_ca");
  keys.require(tls.client_ca || !tls.client_needed, "client_ca beside client_certificates");
}

template <typename Archive>
void visit(Archive& keys, TimeConfig& time) {
  keys.key(
      "mode", time.clients_pace, Word{{"real", "virtual"}},
      "virtual: simulated time passes as CRCL clients poll their status, and by the wall clock "
      "only while nobody does");
  keys.key("poll_period_ms", time.poll_period_ms, Whole{1, 60'000},
           "simulated time that one request of a client that paces takes");
  keys.key("pacers", time.pacers, ListOf<PacerName>{},
           "who paces: time begins when all are there and waits for each of them; whoever polls "
           "when empty");
  keys.key("grace_ms", time.grace_ms, Maybe<Whole>{{0, kDay}},
           "wall time of silence after which a client that paces is left behind, 0 = never; 5000 "
           "without, and never where pacers are declared");
}

template <typename Archive>
void visit(Archive& keys, JournalConfig& journal) {
  keys.key("place", journal.place, Maybe<Text>{},
           "file, or directory for files, in which the run is recorded");
  keys.key("max_file_mb", journal.max_file_mb, Whole{1, 65536},
           "size at which another file is begun, with the next checkpoint [MB]");
  keys.key("memory_minutes", journal.memory_minutes, Whole{1, 1440},
           "so much of the latest is kept in memory, for `aprsim incident` [min simulated]");
  keys.key("memory_mb", journal.memory_mb, Whole{0, 65536},
           "and takes no more than this; 0 = nothing is kept there [MB]");
}

template <typename Archive>
void visit(Archive& keys, HistoryConfig& history) {
  keys.key("minutes", history.minutes, Whole{0, 1440},
           "simulated time of which any moment can be looked at again; 0 = none");
  keys.key("max_mb", history.max_mb, Whole{1, 65536},
           "memory that it may take; the oldest is given up [MB]");
}

template <typename Archive>
void visit(Archive& keys, Config& config) {
  keys.key("scene", config.scene, Text{}, "a shipped scene's name, or a file");
  keys.key("seed", config.seed, Maybe<Whole>{}, "of everything random, in place of the scene's");
  keys.key("speed", config.speed, Pace{}, "what the wall clock has to do with simulated time");
  keys.section("time", config.time, "virtual time");
  keys.key("log_level", config.log_level, Word{{"trace", "debug", "info", "warn", "error"}},
           "least severity of what is logged");
  keys.key("saved_states_mb", config.saved_states_mb, Whole{1, 65536},
           "memory that saved states may take together [MB]");
  keys.section("journal", config.journal, "the record of the run");
  keys.section("history", config.history, "the past of the run, in memory");
  keys.section("connections", config.connections, "the connections of every listener");
  keys.section("access", config.access, "who may what over gRPC and on the page");
  keys.section("tls", config.tls, "encryption of gRPC and the page");
  keys.section("crcl", config.crcl, "CRCL, one listener a robot");
  keys.section("modbus", config.modbus, "Modbus/TCP of the conveyor's PLC");
  keys.section("grpc", config.grpc, "telemetry and control by gRPC");
  keys.section("vision", config.vision, "detections of the overhead cameras, one listener each");
  keys.section("web", config.web, "the web page");
}

}  // namespace aprsim::server
