#include "server/daemon.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "protocols/grpc/grpc_server.hpp"
#include "protocols/modbus/modbus_server.hpp"
#include "protocols/web/web_server.hpp"
#include "server/access/security_context.hpp"
#include "server/cameras/camera_studio.hpp"
#include "server/config/memory_shares.hpp"
#include "server/config/version.hpp"
#include "server/drafts/draft_builder.hpp"
#include "server/drafts/scenario_checker.hpp"
#include "server/journal/journal.hpp"
#include "server/journal/run_header.hpp"
#include "server/journal/state_files.hpp"
#include "server/listeners/robot_listeners.hpp"
#include "server/listeners/scene_listeners.hpp"
#include "server/listeners/server_options.hpp"
#include "server/operations/cell_log.hpp"
#include "server/operations/memory_guard.hpp"
#include "server/operations/metrics.hpp"
#include "server/operations/process.hpp"
#include "server/operations/rejection_bookmarks.hpp"
#include "server/programs/cell_programs.hpp"
#include "world/runtime/history/bookmark_generator.hpp"
#include "world/runtime/history/recorders.hpp"
#include "world/runtime/history/time_machine.hpp"
#include "world/runtime/simulation.hpp"

namespace aprsim::server {
namespace {

/// Period of looking for another scene, and its multiple after which the log and memory are due.
constexpr std::chrono::milliseconds kFollowPeriod{20};
constexpr unsigned kFollowsPerLog = 10;
/// Pictures on their way have one part in so many of the cameras' memory.
constexpr std::uint64_t kSentPart = 8;
/// Ports of Simple Message: motion, state and gripper.
constexpr std::uint64_t kPortsOfRobot = 3;

/// Throws std::runtime_error where there is no directory for the journal's files.
void check_journal_place(const Config& config) {
  if (!config.journal.place) return;
  const std::string& place = *config.journal.place;
  std::error_code none;
  const std::filesystem::path parent = std::filesystem::absolute(place, none).parent_path();
  if (!std::filesystem::is_directory(place, none) && !std::filesystem::is_directory(parent, none)) {
    throw std::runtime_error("journal.place: " + place + ": there is no directory " +
                             parent.string());
  }
}

/// Null where nothing is recorded; throws std::runtime_error when recording cannot begin.
std::unique_ptr<journal::Journal> make_journal(const Config& config, const MemoryShares& shares,
                                               const scene::Scene& scene) {
  if (!config.journal.place && shares.journal_ring == 0) return nullptr;
  check_journal_place(config);
  auto header = journal::header_of(scene);
  if (!header) throw std::runtime_error(header.error().message);
  header->set_version(kVersion);
  header->set_seed(config.seed.value_or(scene.seed));
  header->set_configuration(to_yaml(config));
  const auto add = [&](api::EndpointId number, const std::string& name) {
    auto& endpoint = *header->add_endpoints();
    endpoint.set_number(number);
    endpoint.set_name(name);
  };
  add(kModbusEndpoint, "modbus");
  add(kGrpcEndpoint, "grpc");
  add(kWebEndpoint, "web");
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    const auto number = static_cast<api::EndpointId>(i);
    add(kFirstCrclEndpoint + number, "crcl." + scene.robots[i].name);
    if (!scene.robots[i].simple_message) continue;
    add(kFirstSimpleMessageEndpoint + number, "simple_message." + scene.robots[i].name);
  }
  for (std::size_t i = 0; i < scene.modbus_servers.size(); ++i) {
    add(kFirstMapEndpoint + static_cast<api::EndpointId>(i),
        "modbus." + scene.modbus_servers[i].name);
  }
  journal::JournalOptions options;
  options.place = config.journal.place.value_or("");
  options.max_file_bytes = std::uint64_t{config.journal.max_file_mb} << 20U;
  options.memory_span = std::chrono::minutes(config.journal.memory_minutes);
  options.max_memory_bytes = shares.journal_ring;
  options.max_queue_bytes = shares.journal_queue;
  options.max_waiting_bytes = shares.journal_files;
  options.header = std::move(*header);
  auto journal = std::make_unique<journal::Journal>(std::move(options));
  if (const auto& claimed = journal->claimed(); !claimed) {
    throw std::runtime_error("journal.place: " + claimed.error().message);
  }
  return journal;
}

/// Null where no past is kept.
std::unique_ptr<world::HistoryRecords> make_records(const HistoryConfig& config,
                                                    const MemoryShares& shares,
                                                    const scene::Scene& scene) {
  if (config.minutes == 0) return nullptr;
  world::HistoryLimits limits;
  limits.steps = static_cast<std::uint64_t>(60.0 * config.minutes / scene.physics.step_s);
  limits.bytes = shares.history;
  return std::make_unique<world::HistoryRecords>(limits);
}

using AdmitsScene = std::function<Result<void>(const scene::Scene&)>;

world::SimulationOptions simulation_options(const Config& config, const MemoryShares& shares,
                                            const scene::Scene& scene, world::Recorder* recorder,
                                            AdmitsScene admits_scene) {
  world::SimulationOptions options;
  options.admits_scene = std::move(admits_scene);
  options.recorder = recorder;
  options.seed = config.seed.value_or(scene.seed);
  options.max_saved_bytes = shares.saved_states;
  options.paused = config.speed.mode == Speed::Mode::kStepped;
  if (config.speed.mode == Speed::Mode::kFactor) {
    options.speed = config.speed.factor;
  } else {
    options.speed = std::nullopt;
  }
  if (config.time.clients_pace) {
    options.virtual_time = {.poll_period = std::chrono::milliseconds(config.time.poll_period_ms),
                            .pacers = config.time.pacers,
                            .grace = std::chrono::milliseconds(config.time.grace())};
  }
  return options;
}

/// Throws std::runtime_error where memory.max_mb is too small.
MemoryShares shares_of(const Config& config) {
  const auto shares = memory_shares(config);
  if (!shares) throw std::runtime_error(shares.error().message);
  return *shares;
}

/// Adds the listener's name and a way out.
tl::unexpected<Error> not_listening(const std::string& name, const std::string& key, Error error,
                                    const std::string& value = "PORT") {
  error.field = key;
  error.message = name + ": " + error.message + " (another port: --set " + key + '=' + value +
                  "; any free ones: --any-port)";
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace

/// Listeners are declared after the simulation, to which they refer, so they are destroyed first.
class Daemon::Impl {
  using CameraListeners =
      SceneListeners<camera_server::CameraServer, camera_server::CameraServerOptions>;
  using MapListeners =
      SceneListeners<modbus_server::ModbusServer, modbus_server::ModbusServerOptions>;

 public:
  Impl(const Config& config, std::shared_ptr<const scene::Scene> scene, bool demo)
      : shares_(shares_of(config)),
        journal_(make_journal(config, shares_, *scene)),
        records_(make_records(config.history, shares_, *scene)),
        bookmark_generator_(bookmarks_),
        recorders_({journal_.get(), records_.get(), records_ ? &bookmark_generator_ : nullptr}),
        simulation_(scene, simulation_options(config, shares_, *scene, &recorders_,
                                              [this, config](const scene::Scene& next) {
                                                return admit_scene(config, next);
                                              })),
        history_(records_ ? std::make_unique<world::TimeMachine>(scene, *records_, bookmarks_,
                                                                 &simulation_, shares_.past_states)
                          : nullptr),
        state_files_([this] { return simulation_.scene(); }, kVersion,
                     config.access.allow_foreign_states),
        security_(config, simulation_),
        robots_(robot_source(config)),
        studio_(scene, simulation_,
                {.seed = config.seed.value_or(scene->seed),
                 .max_bytes =
                     (std::uint64_t{config.cameras.max_mb} << 20U) / kSentPart * (kSentPart - 1)}),
        camera_endpoints_(config.cameras.endpoints),
        cameras_(camera_source(config)),
        modbus_(with_tap(modbus_options(context(config)), config, modbus_tap_), simulation_,
                simulation_),
        modbus_maps_(map_source(config, false)),
        secure_maps_(map_source(config, true)),
        telemetry_(grpc_options(config), simulation_, simulation_),
        programs_(config, demo, security_.program_token),
        drafts_(scene),
        scenarios_([this] { return simulation_.scene(); }),
        offered_scene_(scene) {
    crcl_tap_.audit_to(security_.audit.get());
    modbus_tap_.audit_to(security_.audit.get());
    if (config.web.enabled) make_web(config, *scene);
  }

  ~Impl() { stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<Ports> start() {
    Ports ports;
    if (auto listening = robots_.start(); !listening) return robot_not_listening(listening.error());
    ports.merge(robots_.ports());
    if (auto listening = cameras_.start(); !listening) {
      return camera_not_listening(listening.error());
    }
    for (const auto& [name, port] : cameras_.ports()) ports["camera." + name] = port;
    if (auto listening = start_modbus(ports); !listening) return tl::unexpected(listening.error());
    auto grpc = telemetry_.start();
    if (!grpc) return not_listening("grpc", "grpc.port", grpc.error());
    ports["grpc"] = *grpc;
    if (auto begun = programs_.begin(ports); !begun) return tl::unexpected(begun.error());
    ports_ = ports;  // before the page's thread starts to read it
    if (web_) {
      auto web = web_->start();
      if (!web) return not_listening("web", "web.port", web.error());
      ports["web"] = *web;
    }
    all_ports_ = ports;
    simulation_.start();
    cell_log_ = std::jthread([this](const std::stop_token& stop) { log_cell(stop); });
    return ports;
  }

  void on_ports(std::function<void(const Ports&)> take) {
    const std::lock_guard lock(follow_mutex_);
    take_ports_ = std::move(take);
  }

  void reload() { security_.reload(); }
  [[nodiscard]] bool makes_progress() const { return simulation_.makes_progress(); }
  [[nodiscard]] std::string problem() const {
    const std::string problem = simulation_.problem();
    return problem.empty() ? robots_.problem() : problem;
  }

  void finish_journal() {
    if (journal_) journal_->finish();
  }

  /// Listeners stop in parallel, since each may wait for its slowest client; the page stops first,
  /// since it counts the others' connections.
  void stop() {
    {
      // The ports file and the programs may end.
      const std::lock_guard lock(follow_mutex_);
      stopping_ = true;
    }
    programs_.close();
    // So that no listener waits for an answer from it.
    if (history_) history_->stop();
    simulation_.stop_previews();
    drafts_.stop();
    scenarios_.stop();
    if (web_) web_->stop();
    {
      std::vector<std::jthread> ending;
      ending.emplace_back([this] { robots_.stop(); });
      ending.emplace_back([this] { cameras_.stop(); });
      ending.emplace_back([this] { modbus_.stop(); });
      ending.emplace_back([this] { modbus_maps_.stop(); });
      ending.emplace_back([this] { secure_maps_.stop(); });
      ending.emplace_back([this] { telemetry_.stop(); });
    }
    studio_.stop();
    simulation_.stop();
    finish_journal();
    programs_.end();
    if (cell_log_.joinable()) {
      cell_log_.request_stop();
      cell_log_.join();
    }
  }

 private:
  /// Opens the ports of the conveyor and of the scene's servers, each with and without TLS.
  [[nodiscard]] Result<void> start_modbus(Ports& ports) {
    auto modbus = modbus_.start();
    if (!modbus) {
      const bool secure = modbus.error().field == "modbus_tls";
      return not_listening(secure ? "modbus_tls" : "modbus",
                           secure ? "modbus.tls.port" : "modbus.port", modbus.error());
    }
    ports["modbus"] = *modbus;
    if (security_.modbus_tls) ports["modbus_tls"] = modbus_.secure_port();
    if (auto listening = modbus_maps_.start(); !listening) {
      const std::string name = listening.error().field;
      return not_listening("modbus." + name, "modbus.ports." + name, listening.error());
    }
    for (const auto& [name, port] : modbus_maps_.ports()) ports["modbus." + name] = port;
    if (auto listening = secure_maps_.start(); !listening) {
      const std::string name = listening.error().field;
      return not_listening("modbus_tls." + name, "modbus.tls.ports." + name, listening.error());
    }
    for (const auto& [name, port] : secure_maps_.ports()) ports["modbus_tls." + name] = port;
    return {};
  }

  [[nodiscard]] Ports ports() const {
    Ports ports = all_ports_;
    // Names with a dot are of things in the scene.
    std::erase_if(ports,
                  [](const auto& entry) { return entry.first.find('.') != std::string::npos; });
    ports.merge(robots_.ports());
    for (const auto& [name, port] : cameras_.ports()) ports["camera." + name] = port;
    for (const auto& [name, port] : modbus_maps_.ports()) ports["modbus." + name] = port;
    for (const auto& [name, port] : secure_maps_.ports()) ports["modbus_tls." + name] = port;
    return ports;
  }

  /// Lets the listeners follow the scene. Thread: the cell log's.
  void follow_scene() {
    const auto cell = robots_.update();
    cameras_.update();
    modbus_maps_.update();
    secure_maps_.update();
    const Ports now = ports();
    const std::lock_guard lock(follow_mutex_);
    if (stopping_) return;
    programs_.update(now);
    if (take_ports_) take_ports_(now);
    followed_ = cell;
  }

  /// Offers the programs of the present scene. Thread: the cell log's.
  void follow_programs() {
    const auto scene = simulation_.scene();
    if (scene == offered_scene_) return;
    const bool other = scene->file != offered_scene_->file;
    offered_scene_ = scene;
    if (!other) return;
    auto programs = programs_.programs_of(scene->file);
    const std::lock_guard lock(follow_mutex_);
    if (!stopping_) programs_.offer(std::move(programs));
  }

  /// Thread: any.
  [[nodiscard]] bool follows(const api::CellDescription& cell) const {
    const std::lock_guard lock(follow_mutex_);
    return followed_.get() == &cell;
  }

  /// Its field is the listener's name.
  [[nodiscard]] static tl::unexpected<Error> robot_not_listening(const Error& error) {
    const std::string name = error.field;
    const auto dot = name.find('.');
    const std::string kind = name.substr(0, dot), robot = name.substr(dot + 1);
    const bool own = kind == "crcl" || kind == "vision";
    const std::string key = own ? kind + ".ports." + robot : "simple_message." + kind + "." + robot;
    return not_listening(name, key, error);
  }

  /// Refuses another scene whose robots could not be reached, before anything changes. Thread: any.
  [[nodiscard]] Result<void> admit_scene(const Config& config, const scene::Scene& next) const {
    if (auto ok = raise_file_limit(needed_files(config, next)); !ok) return ok;
    const auto listening = robots_.check(next);
    if (listening) return {};
    auto refused = robot_not_listening(listening.error());
    refused.value().code = ErrorCode::kFailedPrecondition;
    return refused;
  }

  /// Its field is the camera's name.
  [[nodiscard]] tl::unexpected<Error> camera_not_listening(const Error& error) const {
    const std::string& name = error.field;
    if (!camera_endpoints_.contains(name)) {
      return not_listening("camera." + name, "cameras.port", error);
    }
    return not_listening("camera." + name, "cameras.endpoints." + name, error, "ADDRESS:PORT");
  }

  /// Logs events of the cell, since the simulation's own thread never writes there, keeps the
  /// limit of memory, and lets the listeners of robots, cameras and Modbus servers follow the
  /// scene.
  void log_cell(const std::stop_token& stop) {
    CellLog cell_log;
    std::mutex mutex;
    std::condition_variable_any condition;
    std::unique_lock lock(mutex);
    // Pictures have memory of their own.
    MemoryGuard memory(
        shares_.total,
        [this] {
          if (records_) records_->drop_older_half();
          if (journal_) journal_->drop_older_half();
        },
        [this] { return resident_bytes() - std::min(resident_bytes(), studio_.bytes()); });
    for (unsigned turn = 0;; ++turn) {
      const bool ended = stop.stop_requested();
      follow_scene();
      follow_programs();
      if (turn % kFollowsPerLog == 0 || ended) {
        memory.check(MemoryGuard::Clock::now());
        for (const CellLogLine& line : cell_log.detect(*simulation_.latest())) {
          spdlog::log(line.error ? spdlog::level::err : spdlog::level::warn, "cell: {}", line.text);
        }
      }
      if (ended) return;
      condition.wait_for(lock, stop, kFollowPeriod, [] { return false; });
    }
  }

  /// Null where neither a past nor a journal is kept.
  [[nodiscard]] protocols::RefusalSink* refusals() {
    return records_ || journal_ ? &rejection_bookmarks_ : nullptr;
  }

  static bool tapped(const Config& config) {
    return config.web.enabled || config.access.audit_file.has_value();
  }

  [[nodiscard]] ListenerContext context(const Config& config) {
    return {config, security_, journal_.get(), refusals(), simulation_.virtual_time()};
  }

  CameraListeners::Source camera_source(const Config& config) {
    return {.kind = "camera",
            .scene = [this] { return studio_.cameras(); },
            .wanted =
                [this, config] {
                  const auto cameras = studio_.cameras();
                  CameraListeners::Wanted wanted;
                  for (std::size_t i = 0; i < cameras->size(); ++i) {
                    const std::string& name = (*cameras)[i].name;
                    wanted[name] = camera_options(context(config), i, name);
                  }
                  return wanted;
                },
            .make =
                [this](const auto& options) {
                  return std::make_unique<camera_server::CameraServer>(options, studio_);
                }};
  }

  /// `secure`: with TLS.
  MapListeners::Source map_source(const Config& config, bool secure) {
    return {.kind = secure ? "modbus_tls" : "modbus",
            .scene = [this] { return simulation_.latest()->cell; },
            .wanted =
                [this, config, secure] {
                  const auto cell = simulation_.latest()->cell;
                  MapListeners::Wanted wanted;
                  if (secure && !security_.modbus_tls) return wanted;
                  for (std::size_t i = 0; i < cell->modbus_servers.size(); ++i) {
                    const std::string& name = cell->modbus_servers[i].name;
                    wanted[name] = with_tap(secure ? secure_map_options(context(config), i, name)
                                                   : map_options(context(config), i, name),
                                            config, modbus_tap_);
                  }
                  return wanted;
                },
            .make =
                [this](const auto& options) {
                  return std::make_unique<modbus_server::ModbusServer>(options, simulation_,
                                                                       simulation_);
                }};
  }

  template <typename Options>
  static Options with_tap(Options options, const Config& config, protocols::WireTap& tap) {
    if (tapped(config)) options.tap = &tap;
    return options;
  }

  RobotListeners::Source robot_source(const Config& config) {
    return {.scene = [this] { return simulation_.scene(); },
            .sink = simulation_,
            .snapshots = simulation_,
            .options =
                [this, config](const scene::Scene& scene, std::size_t index) {
                  const ListenerContext shared = context(config);
                  const scene::Robot& robot = scene.robots[index];
                  const int number = static_cast<int>(index);
                  RobotListenerOptions options{
                      with_tap(crcl_options(shared, number, robot.name), config, crcl_tap_),
                      vision_options(shared, number, robot.name),
                      {}};
                  if (robot.simple_message) {
                    options.simple_message =
                        with_tap(simple_message_options(shared, number, robot), config, crcl_tap_);
                  }
                  return options;
                },
            .max_unfinished_bytes = shares_.documents};
  }

  [[nodiscard]] grpc_server::TelemetryOptions grpc_options(const Config& config) {
    grpc_server::TelemetryOptions options = telemetry_options(context(config));
    options.incidents = journal_.get();
    options.max_memory_bytes = shares_.grpc;
    options.max_backlogs_bytes = shares_.backlogs;
    options.max_unread_bytes = shares_.answers;
    options.cameras = &studio_;
    options.max_unread_image_bytes = (std::size_t{config.cameras.max_mb} << 20U) / kSentPart;
    options.transfers.all_bytes = shares_.transfers;
    options.feed = &simulation_.feed();
    options.events = &simulation_.events();
    options.history = history_.get();
    options.previews = &simulation_.previews();
    options.state_files = &state_files_;
    options.robots = &robots_;
    options.listens = [this](const api::CellDescription& cell) { return follows(cell); };
    return options;
  }

  void make_web(const Config& config, const scene::Scene& scene) {
    auto options = web_options(context(config), scene);
    options.incidents = journal_.get();
    options.max_waiting_bytes = shares_.pages;
    options.crcl_tap = &crcl_tap_;
    options.modbus_tap = &modbus_tap_;
    options.cameras = &studio_;
    options.programs = programs_.for_pages();
    options.history = history_.get();
    options.previews = &simulation_.previews();
    options.drafts = &drafts_;
    options.models = [this] { return models_of(*simulation_.scene()); };
    options.scenarios = &scenarios_;
    options.listeners = [this] { return listeners(); };
    options.metrics = [this] { return metrics_text(metrics_sources()); };
    options.problem = [this] { return robots_.problem(); };
    web_ = std::make_unique<web::WebServer>(std::move(options), simulation_, simulation_);
  }

  /// Thread: the web server's.
  [[nodiscard]] MetricsSources metrics_sources() const {
    MetricsSources sources;
    sources.snapshot = simulation_.latest();
    sources.ready = problem().empty();
    sources.step_times = simulation_.step_times().counts();
    sources.solver = simulation_.solver_work();
    sources.waiting_commands = simulation_.waiting_commands();
    sources.memory = memory();
    for (const auto& [name, stats] : robots_.crcl_stats()) sources.crcl.emplace_back(name, stats);
    for (const auto& [name, stats] : robots_.vision_stats()) {
      sources.vision.emplace_back(name, stats);
    }
    for (const auto& [name, stats] : robots_.simple_message_stats()) {
      sources.simple_message.emplace_back(name, stats);
    }
    for (const auto& [name, stats] : cameras_.stats()) sources.cameras.emplace_back(name, stats);
    sources.modbus = modbus_.stats();
    for (const auto& [name, stats] : modbus_maps_.stats()) {
      sources.modbus_maps.emplace_back(name, stats);
    }
    if (const auto secure = modbus_.secure_stats()) {
      sources.modbus_secure.emplace_back("modbus_tls", *secure);
    }
    for (const auto& [name, stats] : secure_maps_.stats()) {
      sources.modbus_secure.emplace_back("modbus_tls." + name, stats);
    }
    if (journal_) sources.journal = journal_->stats();
    sources.grpc = telemetry_.stats();
    sources.web = web_->stats();
    sources.access.refused = security_.access->counts();
    if (security_.grpc_tls) {
      sources.access.tls_failures = {{"grpc", security_.grpc_tls->failures()},
                                     {"web", security_.web_tls->failures()}};
    }
    if (security_.modbus_tls) {
      sources.access.tls_failures.emplace_back("modbus_tls", security_.modbus_tls->failures());
    }
    if (security_.audit) sources.access.audit = security_.audit->stats();
    return sources;
  }

  [[nodiscard]] MemoryUse memory() const {
    MemoryUse use{.shares = shares_};
    if (journal_) {
      const journal::JournalStats journal = journal_->stats();
      use.journal_ring = journal.memory_bytes;
      use.journal_queues = journal.queued_bytes;
    }
    if (records_) use.history = records_->bytes();
    if (history_) use.past_states = history_->state_bytes();
    const auto saved = simulation_.latest()->saved_states;
    use.saved_states = saved ? saved->bytes : 0;
    use.events = simulation_.events().memory();
    return use;
  }

  /// Thread: the web server's; the ports are set before it starts.
  [[nodiscard]] std::vector<web::ListenerCount> listeners() const {
    std::vector<web::ListenerCount> all;
    const Ports of_robots = robots_.ports();
    const auto add = [&](const std::string& name, std::uint64_t open) {
      const Ports& known = of_robots.contains(name) ? of_robots : ports_;
      const auto port = known.find(name);
      all.push_back({name, port == known.end() ? std::uint16_t{0} : port->second, open});
    };
    const auto messages = robots_.simple_message_stats();
    const auto vision = robots_.vision_stats();
    for (const auto& [name, stats] : robots_.crcl_stats()) {
      add("crcl." + name, stats.open);
      if (const auto of = vision.find(name); of != vision.end())
        add("vision." + name, of->second.open);
      if (const auto of = messages.find(name); of != messages.end()) {
        add("motion." + name, of->second.open);
      }
    }
    const auto ports = cameras_.ports();
    for (const auto& [name, stats] : cameras_.stats()) {
      const auto port = ports.find(name);
      all.push_back(
          {"camera." + name, port == ports.end() ? std::uint16_t{0} : port->second, stats.open});
    }
    add("modbus", modbus_.stats().open);
    const auto maps = modbus_maps_.ports();
    for (const auto& [name, stats] : modbus_maps_.stats()) {
      const auto port = maps.find(name);
      all.push_back(
          {"modbus." + name, port == maps.end() ? std::uint16_t{0} : port->second, stats.open});
    }
    if (const auto secure = modbus_.secure_stats()) add("modbus_tls", secure->open);
    const auto secure_maps = secure_maps_.ports();
    for (const auto& [name, stats] : secure_maps_.stats()) {
      const auto port = secure_maps.find(name);
      all.push_back({"modbus_tls." + name,
                     port == secure_maps.end() ? std::uint16_t{0} : port->second, stats.open});
    }
    add("grpc", telemetry_.stats().open);
    add("web", web_->open());
    return all;
  }

  const MemoryShares shares_;
  std::unique_ptr<journal::Journal> journal_;       // null = the run is not recorded
  std::unique_ptr<world::HistoryRecords> records_;  // null = no past is kept
  world::Bookmarks bookmarks_;
  world::BookmarkGenerator bookmark_generator_;
  world::Recorders recorders_;
  world::Simulation simulation_;
  std::unique_ptr<world::TimeMachine> history_;  // where there are records
  RejectionBookmarks rejection_bookmarks_{bookmarks_, journal_.get(), simulation_};
  journal::SceneStateFiles state_files_;
  SecurityContext security_;
  // The page shows their events; the audit records them.
  protocols::WireTap crcl_tap_{simulation_, shares_.crcl_tap};
  protocols::WireTap modbus_tap_{simulation_, shares_.modbus_tap};
  RobotListeners robots_;  // telemetry refers to their ports
  CameraStudio studio_;
  const std::map<std::string, Endpoint> camera_endpoints_;
  CameraListeners cameras_;
  modbus_server::ModbusServer modbus_;
  MapListeners modbus_maps_, secure_maps_;  // without and with TLS
  grpc_server::TelemetryServer telemetry_;
  Ports ports_;      // of the other listeners, for the page
  Ports all_ports_;  // of all at the start
  CellPrograms programs_;
  DraftBuilder drafts_;
  ScenarioChecker scenarios_;
  std::shared_ptr<const scene::Scene> offered_scene_;  // whose programs pages may start
  std::unique_ptr<web::WebServer> web_;
  mutable std::mutex follow_mutex_;  // of what follows
  bool stopping_ = false;
  std::function<void(const Ports&)> take_ports_;
  std::shared_ptr<const api::CellDescription> followed_;  // whose listeners are open
  std::jthread cell_log_;
};

void Daemon::check(Config config, std::shared_ptr<const scene::Scene> scene) {
  check_journal_place(config);
  // Nothing is recorded, so an earlier run's file stays as it is.
  config.journal.place.reset();
  config.access.audit_file.reset();
  const Impl probe(config, std::move(scene), false);
}

Daemon::Daemon(const Config& config, std::shared_ptr<const scene::Scene> scene, bool demo)
    : impl_(std::make_unique<Impl>(config, std::move(scene), demo)) {}
Daemon::~Daemon() = default;
Result<Ports> Daemon::start() { return impl_->start(); }
void Daemon::on_ports(std::function<void(const Ports&)> take) { impl_->on_ports(std::move(take)); }
void Daemon::stop() { impl_->stop(); }
void Daemon::finish_journal() { impl_->finish_journal(); }
void Daemon::reload() { impl_->reload(); }
bool Daemon::makes_progress() const { return impl_->makes_progress(); }
std::string Daemon::problem() const { return impl_->problem(); }

std::uint64_t needed_files(const Config& config, const scene::Scene& scene) {
  const std::size_t robots = scene.robots.size();
  const std::uint64_t modbus_ports =
      (1 + scene.modbus_servers.size()) * (config.modbus.tls.certificate ? 2U : 1U);
  const std::uint64_t connections = (config.crcl.max_connections + config.vision.max_connections +
                                     kPortsOfRobot * config.simple_message.max_connections) *
                                        robots +
                                    config.cameras.max_connections * scene::kMaxCameras +
                                    config.modbus.max_connections * modbus_ports +
                                    // Each has a socket pair in addition.
                                    std::uint64_t{2} * config.grpc.max_connections +
                                    (config.web.enabled ? config.web.max_connections : 0);
  // Twice the limits, so that clients can never exhaust the descriptors.
  return 2 * connections + web::kMaxRejected + 64;
}

}  // namespace aprsim::server
