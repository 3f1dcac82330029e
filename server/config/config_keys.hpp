#pragma once

#include "server/config/config.hpp"
#include "server/config/config_types.hpp"

/// The keys of the configuration, each once, with value, type and meaning, in the order in which
/// they are read and printed. An archive, in the sense of Drake's Serialize, visits them to read,
/// print or list them. It has
///   key(name, value, type, meaning)            one value,
///   by_robot(name, values, type, meaning)      a value for each robot, by its name,
///   by_camera(name, values, type, meaning)     the same for each camera,
///   by_server(name, values, type, meaning)     the same for each Modbus server of the scene,
///   by_role(name, values, type, meaning)       the same for each role of Modbus Security,
///   section(name, part, meaning)               a map of keys,
///   section_by_robot(name, parts, common, meaning)  a map for each robot; `common` has the values
///                                              of absent keys,
///   require(truth, expected)                   a condition on the keys so far.
namespace aprsim::server {

inline constexpr Whole kConnections{1, 1024};
inline constexpr std::int64_t kDay = 86'400'000;  // [ms]
inline constexpr const char* kAllowed =
    "addresses and networks that may connect besides this machine; none when empty, all with "
    "0.0.0.0/0 and ::/0";

template <typename Archive>
void visit(Archive& keys, CrclRobotConfig& robot) {
  keys.key("length_unit", robot.length_unit, Word{{"meter", "millimeter", "inch"}},
           "length unit of a new connection");
  keys.key("angle_unit", robot.angle_unit, Word{{"degree", "radian"}},
           "angle unit of a new connection");
  keys.key("validation", robot.strict, Word{{"lenient", "strict"}},
           "strict refuses documents that the schema does not allow");
  keys.key("out_of_range", robot.clamp_targets, Maybe<Word>{{{"refuse", "clamp"}}},
           "refuse targets beyond the limits, or clamp them to the limits with a warning; as the "
           "scene's "
           "robot does when absent");
  keys.key("end_effector_done", robot.wait_for_end_effector, Word{{"at_once", "when_settled"}},
           "when SetEndEffector is done: at_once as on the robots' own servers, or when_settled, "
           "once the gripper has stopped moving");
  // As in the cell, a robot completes accepted commands when a connection closes.
  keys.key("end_program_with_client", robot.end_program_with_client, Flag{},
           "end an uploaded program when the client that sent it disconnects");
  keys.key(
      "cartesian_min_m", robot.cartesian_min_m, Maybe<Point>{},
      "lower corner of the tool point's workspace in the robot's reference frame; the reach of "
      "the robot when absent");
  keys.key("cartesian_max_m", robot.cartesian_max_m, Maybe<Point>{},
           "upper corner of that workspace");
  for (std::size_t i = 0; i < 3 && robot.cartesian_min_m && robot.cartesian_max_m; ++i) {
    keys.require((*robot.cartesian_min_m)[i] < (*robot.cartesian_max_m)[i],
                 "cartesian_min_m below cartesian_max_m on every axis");
  }
}

template <typename Archive>
void visit(Archive& keys, CrclConfig& crcl) {
  keys.key("address", crcl.address, Address{}, "address to listen on");
  keys.by_robot("ports", crcl.ports, Port{}, "port of a robot; a free port when absent");
  keys.key("max_connections", crcl.max_connections, kConnections,
           "limit of simultaneous connections to each robot");
  keys.key("allow", crcl.allow, ListOf<Network>{}, kAllowed);
  keys.key("document_timeout_ms", crcl.document_timeout_ms, Whole{10, kDay},
           "time limit for the rest of a document after its first byte [ms]");
  keys.key("idle_timeout_ms", crcl.idle_timeout_ms, Whole{0, kDay},
           "close a connection that has sent nothing for this time; 0 = never [ms]");
  visit(keys, crcl.all);
  keys.section_by_robot("robots", crcl.robots, crcl.all,
                        "settings of one robot that differ from those of all");
}

template <typename Archive>
void visit(Archive& keys, ModbusTlsConfig& tls) {
  const Word rights{{"none", "view", "operate"}};
  keys.key(
      "certificate", tls.certificate, Maybe<Text>{},
      "PEM file of the server's certificate with its intermediate ones; no Modbus Security when "
      "absent");
  keys.key("key", tls.key, Maybe<Text>{}, "PEM file of the private key, without a password");
  keys.key("client_ca", tls.client_ca, Maybe<Text>{},
           "PEM file of the authorities that sign client certificates, which every client shows");
  keys.key("min_version", tls.only_tls_1_3, Word{{"1.2", "1.3"}}, "oldest version of TLS");
  keys.key("address", tls.address, Address{}, "address to listen on");
  keys.key("port", tls.port, Port{}, "port of the conveyor's PLC");
  keys.by_server("ports", tls.ports, Port{},
                 "port of a server of the scene; a free port when absent");
  keys.by_role("roles", tls.roles, rights,
               "rights of a role in client certificates: view reads, operate also writes; a role "
               "that is absent has none");
  keys.key("no_role", tls.no_role, rights, "rights of client certificates without a role");
  keys.require(tls.certificate.has_value() == tls.key.has_value() &&
                   tls.certificate.has_value() == tls.client_ca.has_value(),
               "certificate, key and client_ca together");
  keys.require(!tls.certificate || !tls.roles.empty() || tls.no_role != "none",
               "roles together with certificate");
}

template <typename Archive>
void visit(Archive& keys, ModbusConfig& modbus) {
  keys.key("address", modbus.address, Address{}, "address to listen on");
  keys.key("port", modbus.port, Port{}, "port of the conveyor's PLC");
  keys.by_server("ports", modbus.ports, Port{},
                 "port of a server of the scene; a free port when absent");
  keys.key("max_connections", modbus.max_connections, kConnections,
           "limit of simultaneous connections to each server");
  keys.key("forward_is_one", modbus.forward_is_one, Flag{},
           "whether 1 in register 0x8001 means forward");
  keys.key("full_scale_m_s", modbus.full_scale_m_s, Number{yaml::kPositive},
           "belt speed for 32768 in register 0x8002 [m/s]");
  keys.key("allow", modbus.allow, ListOf<Network>{}, kAllowed);
  keys.key("unit_ids", modbus.unit_ids, ListOf<Whole>{{0, 255}},
           "unit ids that are answered; all when empty");
  keys.key("read_only", modbus.read_only, Flag{}, "refuse functions that write");
  keys.key("max_requests_per_s", modbus.max_requests_per_s, RateLimit{},
           "limit of requests per second and connection; stops are always served");
  keys.key("request_timeout_ms", modbus.request_timeout_ms, Whole{10, kDay},
           "time limit for the rest of a request and for accepting a reply [ms]");
  keys.key("idle_timeout_ms", modbus.idle_timeout_ms, Whole{0, kDay},
           "close a connection without a request for this time; 0 = never [ms]");
  keys.key("watchdog_ms", modbus.watchdog_ms, Whole{0, kDay},
           "simulated time without a write after which the belt stops; 0 = never [ms]");
  keys.section("tls", modbus.tls, "Modbus Security: Modbus/TCP over TLS");
}

template <typename Archive>
void visit(Archive& keys, GrpcConfig& grpc) {
  keys.key("address", grpc.address, Address{}, "address to listen on");
  keys.key("port", grpc.port, Port{}, "port to listen on");
  keys.key("max_connections", grpc.max_connections, kConnections,
           "limit of simultaneous connections");
}

template <typename Archive>
void visit(Archive& keys, VisionConfig& vision) {
  keys.key("address", vision.address, Address{}, "address to listen on");
  keys.by_robot("ports", vision.ports, Port{}, "port of a robot's camera; a free port when absent");
  keys.key("max_connections", vision.max_connections, kConnections,
           "limit of simultaneous connections to each camera");
  keys.key("allow", vision.allow, ListOf<Network>{}, kAllowed);
  keys.key("empty_slots", vision.empty_slots, Flag{},
           "also list slots in which nothing was detected");
  // The simulated cameras of APRS send a frame at least every half second; repeating faster than a
  // client polls is useless.
  keys.key("repeat_s", vision.repeat_s, Number{yaml::between(0.01, 0.5)},
           "wall time after which a frame is repeated if no other has come [s]");
}

template <typename Archive>
void visit(Archive& keys, CamerasConfig& cameras) {
  keys.key("address", cameras.address, Address{}, "address to listen on");
  keys.key("port", cameras.port, Port{},
           "port of the first camera, the others follow; 0: free ports for all");
  keys.by_camera("endpoints", cameras.endpoints, EndpointText{},
                 "address and port of one camera, in place of the common ones; for cameras of any "
                 "scene");
  keys.key("max_connections", cameras.max_connections, kConnections,
           "limit of simultaneous connections to each camera");
  keys.key(
      "max_mb", cameras.max_mb, Whole{32, 65536},
      "limit of the memory that takes pictures, in addition to memory.max_mb; it is used while "
      "pictures are asked for [MB]");
  keys.key("allow", cameras.allow, ListOf<Network>{}, kAllowed);
}

template <typename Archive>
void visit(Archive& keys, SimpleMessageConfig& simple_message) {
  keys.key("address", simple_message.address, Address{}, "address to listen on");
  keys.key("ports", simple_message.free_ports, ScenePorts{},
           "ports of the scene's robots, or free ones");
  keys.by_robot("motion", simple_message.motion, Port{},
                "port of a robot's motion, in place of the scene's");
  keys.by_robot("state", simple_message.state, Port{},
                "port of a robot's state, in place of the scene's");
  keys.by_robot("gripper", simple_message.gripper, Port{},
                "port of a robot's gripper or I/O, in place of the scene's");
  keys.key("max_connections", simple_message.max_connections, kConnections,
           "limit of simultaneous connections to each port");
  keys.key("allow", simple_message.allow, ListOf<Network>{}, kAllowed);
}

template <typename Archive>
void visit(Archive& keys, WebConfig& web) {
  keys.key("enabled", web.enabled, Flag{}, "serve the web page");
  keys.key("address", web.address, Address{}, "address to listen on");
  keys.key("port", web.port, Port{}, "port to listen on");
  keys.key("max_connections", web.max_connections, kConnections,
           "limit of simultaneous connections");
  keys.key("max_viewers", web.max_viewers, kConnections, "limit of pages that show the cell");
  keys.key("max_rate_hz", web.max_rate_hz, Number{yaml::between(1, 60)},
           "states of the cell per second and page [Hz]");
  keys.key("control", web.control, Flag{},
           "let pages send commands; false also makes gRPC require credentials");
  keys.key("token", web.token, Secret{8},
           "token with the role admin for the page and gRPC, besides those of access.file");
  keys.key("token_file", web.token_file, Maybe<Text>{}, "file whose first line is the token");
  keys.key("hosts", web.hosts, ListOf<Text>{},
           "host names of this machine in URLs, besides localhost");
  keys.key("programs", web.programs, Maybe<Flag>{},
           "let pages with the right to command start the kitting controller and scenarios; when "
           "absent, only pages on this machine may");
  keys.require(!web.programs.value_or(false) || web.control,
               "control: true together with programs: true");
}

template <typename Archive>
void visit(Archive& keys, ConnectionsConfig& connections) {
  keys.key("per_address", connections.per_address, kConnections,
           "limit of connections from one address to one listener; this machine is exempt");
  keys.key("yield_after_ms", connections.yield_after_ms, Whole{0, kDay},
           "idle time after which a connection is closed if a new client needs its place [ms]");
}

template <typename Archive>
void visit(Archive& keys, AccessConfig& access) {
  keys.key("file", access.file, Maybe<Text>{},
           "file of tokens, and of names in client certificates, with their roles; created by "
           "aprsimd token, with mode 600");
  keys.key("anonymous", access.allow_anonymous_view, Word{{"none", "view"}},
           "role of callers without credentials over gRPC and on the page; on this machine it "
           "applies only where credentials are required");
  keys.key("insecure_control", access.insecure_control, Flag{},
           "allow all commands without credentials, also from other machines");
  keys.key("allow_foreign_states", access.allow_foreign_states, Flag{},
           "load saved states that no daemon of this user has signed");
  keys.key("audit_file", access.audit_file, Maybe<Text>{},
           "file to which each command and its sender are appended as JSON lines");
  keys.require(!access.insecure_control || access.allow_anonymous_view,
               "anonymous: view together with insecure_control: true");
}

template <typename Archive>
void visit(Archive& keys, TlsConfig& tls) {
  keys.key("certificate", tls.certificate, Maybe<Text>{},
           "PEM file of the certificate for gRPC and the page; both are unencrypted when absent");
  keys.key("key", tls.key, Maybe<Text>{}, "PEM file of the private key, without a password");
  keys.key("client_ca", tls.client_ca, Maybe<Text>{},
           "PEM file of the authorities that sign client certificates");
  keys.key("client_certificates", tls.client_needed, Word{{"optional", "required"}},
           "required: refuse clients without a certificate of these authorities");
  keys.require(tls.certificate.has_value() == tls.key.has_value(), "both certificate and key");
  keys.require(tls.certificate || !tls.client_ca, "certificate and key together with client_ca");
  keys.require(tls.client_ca || !tls.client_needed, "client_ca together with client_certificates");
}

template <typename Archive>
void visit(Archive& keys, TimeConfig& time) {
  keys.key(
      "mode", time.clients_pace, Word{{"real", "virtual"}},
      "virtual: status polls of CRCL clients advance simulated time; without polls the wall clock "
      "does");
  keys.key("poll_period_ms", time.poll_period_ms, Whole{1, 60'000},
           "simulated time of one request of a pacing client [ms]");
  keys.key("pacers", time.pacers, ListOf<PacerName>{},
           "clients that pace time, which begins when all are connected and waits for each; every "
           "client that polls when empty");
  keys.key("grace_ms", time.grace_ms, Maybe<Whole>{{0, kDay}},
           "wall time of silence after which time goes on without a pacing client, 0 = never; "
           "when absent 5000, or never where pacers are declared [ms]");
}

template <typename Archive>
void visit(Archive& keys, JournalConfig& journal) {
  keys.key("place", journal.place, Maybe<Text>{}, "file or directory in which the run is recorded");
  keys.key("max_file_mb", journal.max_file_mb, Whole{1, 65536},
           "size after which the next checkpoint begins a new file [MB]");
  keys.key("memory_minutes", journal.memory_minutes, Whole{1, 1440},
           "simulated time of the run that is kept in memory for `aprsim incident` [min]");
  keys.key("memory_mb", journal.memory_mb, Maybe<Whole>{{0, 65536}},
           "limit of that memory, 0 = keep nothing; a share of memory.max_mb when absent [MB]");
}

template <typename Archive>
void visit(Archive& keys, HistoryConfig& history) {
  keys.key("minutes", history.minutes, Whole{0, 1440},
           "simulated time in which any past moment can be queried; 0 = none [min]");
  keys.key("max_mb", history.max_mb, Maybe<Whole>{{1, 65536}},
           "limit of its memory, beyond which the oldest is dropped; a share of memory.max_mb when "
           "absent [MB]");
}

template <typename Archive>
void visit(Archive& keys, MemoryConfig& memory) {
  keys.key("max_mb", memory.max_mb, Whole{192, 65536},
           "limit of the daemon's memory, from which journal, history, saved states and clients "
           "have their shares [MB]");
  keys.key("saved_states_mb", memory.saved_states_mb, Maybe<Whole>{{1, 65536}},
           "limit of the memory of all saved states; a share of max_mb when absent [MB]");
}

template <typename Archive>
void visit(Archive& keys, Config& config) {
  keys.key("scene", config.scene, Text{}, "name of a shipped scene, or a file");
  keys.key("seed", config.seed, Maybe<Whole>{}, "random seed, in place of the scene's");
  keys.key("speed", config.speed, Pace{}, "ratio of simulated time to wall time");
  keys.section("time", config.time, "virtual time");
  keys.key("log_level", config.log_level, Word{{"trace", "debug", "info", "warn", "error"}},
           "least severity of logged messages");
  keys.key("extensions", config.extensions, ListOf<Text>{},
           "directories of the libraries of devices that scenes name");
  keys.section("memory", config.memory, "memory of the daemon");
  keys.section("journal", config.journal, "recording of the run");
  keys.section("history", config.history, "past of the run, in memory");
  keys.section("connections", config.connections, "connections of all listeners");
  keys.section("access", config.access, "access over gRPC and on the page");
  keys.section("tls", config.tls, "encryption of gRPC and the page");
  keys.section("crcl", config.crcl, "CRCL, one listener per robot");
  keys.section("modbus", config.modbus,
               "Modbus/TCP of the conveyor, and of the servers of the scene");
  keys.section("grpc", config.grpc, "telemetry and control over gRPC");
  keys.section("vision", config.vision,
               "detections of the overhead cameras, one listener per camera");
  keys.section("cameras", config.cameras, "pictures of the scene's cameras, one listener each");
  keys.section("simple_message", config.simple_message,
               "ROS-Industrial's Simple Message of robots whose scene has it");
  keys.section("web", config.web, "web page");
}

}  // namespace aprsim::server
