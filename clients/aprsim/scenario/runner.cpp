#include "clients/aprsim/scenario/runner.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cell_connection.hpp"
#include "clients/aprsim/fault_request.hpp"
#include "clients/aprsim/interruption.hpp"
#include "clients/aprsim/scenario/sampler.hpp"
#include "clients/aprsim/scenario/scores.hpp"
#include "clients/aprsim/status_text.hpp"
#include "clients/process/child_process.hpp"
#include "clients/process/own_programs.hpp"

namespace aprsim::client {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using process::ChildProcess;

constexpr double kSamplesPerSecond = 50;  // of simulated time, where the wire keeps up
constexpr double kMostSamplesPerSecond = 400;
constexpr std::uint64_t kVirtualSteps = 25;  // from sample to sample in virtual time, as of polls
constexpr auto kStartTime = 20s;             // for a daemon to listen
constexpr auto kEndTime = 10s;               // for a program to end when it is told to
constexpr auto kHomeTime = 30s;              // for a controller that has no more orders
constexpr auto kAnswerTime = 60s;            // for it to answer a line, while time stands
constexpr auto kStepTime = 50ms;  // for the steps of a sample, before the controller is looked at
constexpr auto kProgressPeriod = 500ms;  // from one telling of the progress to the next

/// A directory of the run's own, gone with it.
class RunDirectory {
 public:
  explicit RunDirectory(const std::string& kept) : kept_(!kept.empty()) {
    std::error_code status;
    if (kept_) {
      fs::create_directories(kept, status);
      path_ = kept;
      return;
    }
    std::string name = (fs::temp_directory_path(status) / "aprsim-run-XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~RunDirectory() {
    std::error_code ignored;
    if (!kept_ && !path_.empty()) fs::remove_all(path_, ignored);
  }
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;
  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
  bool kept_;
};

std::string last_lines(const std::string& file) {
  std::ifstream in(file);
  std::string text, line;
  while (std::getline(in, line)) {
    text += line + '\n';
    if (text.size() > 2000) text.erase(0, text.size() - 2000);
  }
  return text;
}

/// Those that the scenario lets the kitting controller use, else all of the scene.
std::vector<std::string> robots_of(const scenario::Scenario& scenario, const scenario::Plan& plan) {
  std::vector<std::string> robots;
  const auto& options = scenario.controller_options;
  const auto chosen = std::ranges::find(options, "--robots");
  if (chosen != options.end() && chosen + 1 != options.end()) {
    std::istringstream names(*(chosen + 1));
    for (std::string name; std::getline(names, name, ',');) robots.push_back(name);
    return robots;
  }
  for (const auto& robot : plan.scene.robots) robots.push_back(robot.name);
  return robots;
}

/// Who passes virtual time beside the runner: whoever polls and looks.
std::vector<std::string> roles_of(const std::vector<std::string>& robots, bool looks) {
  std::vector<std::string> out;
  for (const std::string& robot : robots) {
    out.push_back("crcl." + robot);
    if (looks) out.push_back("vision." + robot);
  }
  return out;
}

std::string pacers_of(const std::vector<std::string>& roles) {
  std::string out = "grpc";
  for (const std::string& role : roles) out += ',' + role;
  return out;
}

Outcome<ChildProcess> start_daemon(const scenario::Plan& plan, const RunDirectory& directory,
                                   const std::string& pacers) {
  const std::string scene = directory.file("scene.yaml"), ports = directory.file("ports.json");
  std::error_code status;
  fs::remove(ports, status);
  if (std::ofstream file(scene); !(file << plan.scene_text << std::flush)) {
    return failed(FailureKind::kUsage, "cannot write " + scene);
  }
  std::vector<std::string> arguments{process::program_beside("aprsimd"),
                                     "--scene",
                                     scene,
                                     "--seed",
                                     std::to_string(plan.seed),
                                     "--any-port",
                                     "--no-web",
                                     "--ports-file",
                                     ports};
  const std::vector<std::string> pace =
      pacers.empty() ? std::vector<std::string>{"--speed", "stepped"}
                     : std::vector<std::string>{"--time", "virtual", "--pacers", pacers};
  arguments.insert(arguments.end(), pace.begin(), pace.end());
  auto daemon = ChildProcess::start(arguments, {{"APRSIM_TOKEN", ""}},
                                    directory.file("aprsimd.log"), ChildProcess::Pipes::kNone);
  if (!daemon) return failed(FailureKind::kUsage, daemon.error().message);
  const auto deadline = std::chrono::steady_clock::now() + kStartTime;
  while (!fs::exists(ports, status)) {
    if (interruption::noted()) return failed(FailureKind::kInterrupted, "interrupted");
    if (daemon->ended() || std::chrono::steady_clock::now() > deadline) {
      return failed(FailureKind::kCheck,
                    "the daemon does not serve: " + last_lines(directory.file("aprsimd.log")));
    }
    interruption::sleep_until(std::chrono::steady_clock::now() + 5ms);
  }
  return std::move(*daemon);
}

/// Where the cell of a run is.
struct Place {
  Endpoints endpoints;
  std::string ports_file;              ///< empty = none
  std::optional<ChildProcess> daemon;  ///< absent = somebody else's
};

/// A daemon of the run's own.
Outcome<Place> own_place(const scenario::Plan& plan, const RunDirectory& directory,
                         const std::string& pacers) {
  auto daemon = start_daemon(plan, directory, pacers);
  if (!daemon) return tl::unexpected(daemon.error());
  Place place{.ports_file = directory.file("ports.json")};
  place.daemon.emplace(std::move(*daemon));
  auto endpoints = read_ports_file(place.ports_file);
  if (!endpoints) return tl::unexpected(endpoints.error());
  place.endpoints = std::move(*endpoints);
  return place;
}

/// Sets a cell that runs already to its beginning, where it waits.
Outcome<void> make_ready(const scenario::Scenario& scenario, const scenario::Plan& plan,
                         CellConnection& cell) {
  if (scenario.own_parts) {
    return failed(FailureKind::kUsage,
                  scenario.file +
                      ": a running cell keeps its own parts, and this scenario takes "
                      "some out or puts some in");
  }
  const auto description = cell.cell();
  if (!description) return tl::unexpected(description.error());
  if (description->scene() != plan.scene.name) {
    return failed(FailureKind::kUsage, scenario.file + ": is for scene " + plan.scene.name +
                                           ", and the cell has scene " + description->scene());
  }
  if (const auto paused = cell.pause(); !paused) return tl::unexpected(paused.error());
  if (const auto reset = cell.reset(plan.seed); !reset) {
    static_cast<void>(cell.resume());
    return tl::unexpected(reset.error());
  }
  return {};
}

std::vector<std::string> controller_command(const scenario::Scenario& scenario,
                                            const RunOptions& options, const Place& place) {
  if (!options.controller.empty()) return {"/bin/sh", "-c", options.controller};
  // Polls as often in simulated time as at real speed, as far as that is possible.
  const double poll_ms =
      options.virtual_time ? 25 : std::clamp(25 / options.speed.value_or(25), 1.0, 25.0);
  std::vector<std::string> out = {"python3",   process::kitting_program(), "--cell",  scenario.cell,
                                  "--host",    place.endpoints.host,       "--order", "-",
                                  "--poll-ms", fmt::format("{}", poll_ms)};
  if (!place.ports_file.empty()) {
    out.insert(out.end(), {"--ports-file", place.ports_file});
  }
  if (options.virtual_time) out.insert(out.end(), {"--clock", "polls"});
  out.insert(out.end(), scenario.controller_options.begin(), scenario.controller_options.end());
  return out;
}

/// The controller, which may be killed and started again.
class Controller {
 public:
  Controller(std::vector<std::string> command, std::string ports_file,
             const RunDirectory& directory)
      : command_(std::move(command)), ports_file_(std::move(ports_file)), directory_(directory) {}

  /// In place of the one that there was, which is killed with all that it has started.
  Outcome<void> start() {
    process_.reset();
    const std::string log =
        ++starts_ == 1 ? "controller.log" : fmt::format("controller_{}.log", starts_);
    auto started = ChildProcess::start(command_, {{"APRSIM_PORTS_FILE", ports_file_}},
                                       directory_.file(log), ChildProcess::Pipes::kInputAndOutput);
    if (!started) return failed(FailureKind::kUsage, started.error().message);
    process_.emplace(std::move(*started));
    return {};
  }
  void kill() {
    process_->signal(SIGKILL);
    static_cast<void>(process_->wait(kEndTime));
  }
  [[nodiscard]] bool is_there() const { return process_.has_value(); }
  [[nodiscard]] ChildProcess& process() { return *process_; }

 private:
  std::vector<std::string> command_;
  std::string ports_file_;
  const RunDirectory& directory_;
  std::optional<ChildProcess> process_;
  int starts_ = 0;
};

FaultInjectCommand command_of(const scenario::Fault& fault) {
  FaultInjectCommand out{.kind = fault.kind,
                         .target = fault.target,
                         .parameters = fault.parameters,
                         .when = fault.when,
                         .for_s = fault.for_s};
  if (fault.at_s) out.at_s = fault.at_s->front();
  return out;
}

/// What goes on in the cell, in words.
std::string activity_of(const v1::Snapshot& snapshot) {
  std::string out;
  for (const auto& robot : snapshot.robots()) {
    out += (out.empty() ? "" : ", ") + robot.name() + (robot.moving() ? " moves" : " stands");
    if (robot.gripper().holding() && robot.gripper().has_held_index()) {
      out += " with " + snapshot.bodies(static_cast<int>(robot.gripper().held_index())).name();
    } else if (robot.gripper().setting() < 0.5) {
      out += ", told to grip";
    }
  }
  return out + (std::abs(snapshot.conveyor().speed_m_s()) > 1e-4 ? ", the belt runs" : "");
}

/// One run from the first sample to the stop condition.
class Run {
 public:
  Run(const scenario::Scenario& scenario, const scenario::Plan& plan, CellConnection& cell,
      v1::CellDescription description, ChildProcess* controller, bool speaks, std::ostream& heard,
      const RunListener& listener)
      : scenario_(scenario),
        plan_(plan),
        cell_(cell),
        description_(std::move(description)),
        controller_(controller),
        speaks_(speaks),
        heard_(heard),
        listener_(listener),
        measures_(shape_of(description_), scenario.orders) {}

  Outcome<void> inject() {
    for (const scenario::Fault& fault : plan_.faults) {
      const auto taken = cell_.inject_fault(fault_request(command_of(fault)));
      if (!taken) return tl::unexpected(taken.error());
      injected_.push_back(taken->fault().id());
      if (!fault.name.empty()) fault_ids_[fault.name] = taken->fault().id();
    }
    return {};
  }

  /// Of the faults that it has injected none is left. Those that are over already cannot be ended.
  void end_faults() {
    for (const std::uint64_t id : injected_) static_cast<void>(cell_.end_fault(id));
  }

  /// The next sample; false when the run is over.
  bool take(const v1::Snapshot& snapshot) {
    if (interruption::noted()) return end("interrupted");
    if (!snapshot.world_fault().empty()) return end("the cell stopped: " + snapshot.world_fault());
    if (epoch_.value_or(snapshot.epoch()) != snapshot.epoch()) {
      return end("somebody else has reset the cell");
    }
    epoch_ = snapshot.epoch();
    const Sample sample = sample_of(snapshot, description_);
    time_s_ = sample.time_s;
    measures_.add(sample);
    note_faults(sample);
    move_orders_on();
    listen();
    submit_silently();
    const bool goes_on = go_on();
    tell_progress(!goes_on);
    return goes_on;
  }

  /// In virtual time: until the kitting controller has taken in all that it has been told; time
  /// stands meanwhile.
  void await_answers() {
    const auto deadline = std::chrono::steady_clock::now() + kAnswerTime;
    while (controller_ != nullptr && unanswered_ > 0 && !controller_->ended() &&
           !interruption::noted() && std::chrono::steady_clock::now() < deadline) {
      listen();
      if (unanswered_ > 0) static_cast<void>(controller_->wait(1ms));
    }
  }
  void expect_answer() { ++unanswered_; }

  /// What the controller says while it ends.
  void listen() {
    if (controller_ == nullptr) return;
    for (const std::string& line : controller_->lines()) hear(line);
  }

  RunResult result() const {
    RunResult out{.scenario = scenario_.name,
                  .description = scenario_.description,
                  .seed = plan_.seed,
                  .ended = ended_,
                  .measured = measures_.result(words_),
                  .events = events_};
    if (!plan_.kills_s.empty())
      out.measured.values["controller_kills"] = static_cast<double>(kills_);
    if (kills_ > 0) out.measured.values["controller_killed_s"] = killed_s_;
    add_scores(out.measured, scenario_.scoring);
    out.verdicts = judge(out.measured, scenario_.expected);
    return out;
  }

  /// Whether the controller is to be killed now.
  [[nodiscard]] bool kill_is_due() const {
    return controller_ != nullptr && kills_ < plan_.kills_s.size() &&
           time_s_ >= plan_.kills_s[kills_];
  }

  /// It is gone; what it has said is heard first.
  void controller_killed(const v1::Snapshot& snapshot) {
    listen();
    controller_ = nullptr;
    unanswered_ = 0;
    ++kills_;
    killed_s_ = time_s_;
    note("the controller is killed and started again; " + activity_of(snapshot));
  }

  /// One that knows nothing: all orders that still hold are announced to it.
  void controller_started(ChildProcess& controller) {
    controller_ = &controller;
    for (const scenario::Order& order : scenario_.orders) {
      if (announced_.contains(order.name) && !cancelled_.contains(order.name)) announce(order);
    }
  }

  [[nodiscard]] bool all_submitted() const { return ended_ == kAllSubmitted; }

 private:
  static constexpr const char* kAllSubmitted = "all orders were submitted";

  bool end(const std::string& why) {
    ended_ = why;
    return false;
  }

  void note(const std::string& what) {
    events_.push_back({time_s_, what});
    listener_.event(events_.back());
  }

  void note_faults(const Sample& sample) {
    for (const FaultSample& fault : sample.faults) {
      const std::string name = fault.kind + (fault.target.empty() ? "" : " ") + fault.target;
      if (fault.begin_s && begun_.insert(fault.id).second) note("fault begins: " + name);
      if (fault.begin_s && fault.end_s && *fault.end_s > *fault.begin_s &&
          over_.insert(fault.id).second) {
        note("fault ends: " + name);
      }
    }
  }

  [[nodiscard]] bool has_come(const scenario::Moment& moment) const {
    if (const auto* at_s = std::get_if<double>(&moment)) return time_s_ >= *at_s;
    if (const auto* placed = std::get_if<scenario::OnPlaced>(&moment)) {
      return measures_.placed() >= placed->count;
    }
    if (const auto* submitted = std::get_if<scenario::OnSubmitted>(&moment)) {
      return announced_.contains(submitted->order) && measures_.open(submitted->order) == 0;
    }
    const auto id = fault_ids_.find(std::get<scenario::OnFault>(moment).fault);
    return id != fault_ids_.end() && begun_.contains(id->second);
  }

  void report(const std::string& order, const char* what) {
    note(fmt::format("{}: {}", what, order));
    // Faults may wait for it; that the daemon has gone shows elsewhere.
    static_cast<void>(cell_.report_event(std::string("order-") + what));
    static_cast<void>(cell_.report_event(order + '-' + what));
  }

  void send(const nlohmann::ordered_json& message) {
    if (controller_ == nullptr) return;
    controller_->write_line(message.dump());
    expect_answer();
  }

  void announce(const scenario::Order& order) {
    send({{"announce", order.name},
          {"tray", order.tray},
          {"count", order.count},
          {"priority", order.priority},
          {"slots", order.slots}});
  }

  void move_orders_on() {
    for (const scenario::Order& order : scenario_.orders) {
      if (!announced_.contains(order.name) && has_come(order.announced)) {
        announced_.insert(order.name);
        measures_.announced(order.name);
        announce(order);
        report(order.name, "announced");
      }
      if (order.cancelled && announced_.contains(order.name) && !cancelled_.contains(order.name) &&
          has_come(*order.cancelled)) {
        cancelled_.insert(order.name);
        measures_.cancelled(order.name);
        send({{"cancel", order.name}});
        report(order.name, "cancelled");
      }
    }
  }

  void hear(const std::string& line) {
    heard_ << line << std::endl;
    const auto message = nlohmann::json::parse(line, nullptr, /*allow_exceptions=*/false);
    if (!message.is_object()) return;
    speaks_ = true;
    if (message.contains("replan")) {
      words_.replans = words_.replans.value_or(0) + (message.value("replan", false) ? 1U : 0U);
    }
    for (const auto& [name, count] : {std::pair("crcl_requests", &words_.crcl_requests),
                                      std::pair("modbus_requests", &words_.modbus_requests),
                                      std::pair("vision_frames", &words_.vision_frames)}) {
      if (message.contains(name) && message[name].is_number()) *count = message[name];
    }
    if (!message.contains("event")) return;
    const auto& event = message["event"];
    const bool answers = event == "announced" || event == "cancelled" || event == "order_error" ||
                         event == "orders_end";
    if (answers && unanswered_ > 0) --unanswered_;
    if (event != "submit") return;
    const auto order = message.find("order");
    if (order == message.end() || !order->is_string() ||
        !announced_.contains(order->get<std::string>())) {
      note("the controller submits an order that there is not: " + line.substr(0, 200));
      return;
    }
    std::optional<Eigen::Vector2d> place;
    if (message.contains("x_m") && message.contains("y_m") && message["x_m"].is_number() &&
        message["y_m"].is_number()) {
      place = Eigen::Vector2d(message["x_m"].get<double>(), message["y_m"].get<double>());
    }
    submit(order->get<std::string>(), place);
  }

  void submit(const std::string& order, const std::optional<Eigen::Vector2d>& place) {
    if (measures_.submitted(order, place)) report(order, "submitted");
  }

  /// For a controller that does not say when it is done.
  void submit_silently() {
    if (speaks_) return;
    for (const std::string& order : announced_) {
      for (unsigned i = std::min(measures_.open(order), measures_.fulfilled(order)); i > 0; --i) {
        submit(order, {});
      }
    }
  }

  void tell_progress(bool at_once) {
    const auto now = std::chrono::steady_clock::now();
    if (!listener_.progress || (!at_once && now < progress_due_)) return;
    progress_due_ = now + kProgressPeriod;
    RunProgress progress{.time_s = time_s_, .placed = measures_.placed()};
    for (const scenario::Order& order : scenario_.orders) {
      const unsigned open = measures_.open(order.name);
      const bool announced = announced_.contains(order.name);
      const char* const state = cancelled_.contains(order.name) ? "cancelled"
                                : !announced                    ? "waits"
                                : open > 0                      ? "open"
                                                                : "done";
      progress.orders.push_back({.name = order.name,
                                 .tray = order.tray,
                                 .state = state,
                                 .kits = order.count,
                                 .submitted = measures_.submitted_kits(order.name),
                                 .parts = measures_.filled(order.name),
                                 .parts_wanted = order.count * order.slots.size()});
    }
    listener_.progress(progress);
  }

  [[nodiscard]] bool all_done() const {
    return std::ranges::all_of(scenario_.orders, [&](const scenario::Order& order) {
      return announced_.contains(order.name) && measures_.open(order.name) == 0;
    });
  }

  bool go_on() {
    if (scenario_.stop.orders_submitted && all_done()) return end(kAllSubmitted);
    if (time_s_ >= scenario_.stop.time_limit_s) return end("the time limit was reached");
    if (scenario_.stop.quiet_s && measures_.quiet_s() >= *scenario_.stop.quiet_s) {
      return end("nothing moved any more");
    }
    if (controller_ != nullptr && controller_->ended()) {
      listen();
      return end(fmt::format("the controller ended with {}", *controller_->ended()));
    }
    return true;
  }

  const scenario::Scenario& scenario_;
  const scenario::Plan& plan_;
  CellConnection& cell_;
  v1::CellDescription description_;
  ChildProcess* controller_;  ///< null when it is not ours
  bool speaks_;               ///< it says what it does
  std::ostream& heard_;       ///< all that it says
  const RunListener& listener_;
  Measures measures_;
  ControllerWords words_;
  std::map<std::string, std::uint64_t> fault_ids_;
  std::vector<std::uint64_t> injected_;
  std::set<std::uint64_t> begun_, over_;
  std::set<std::string> announced_, cancelled_;
  std::vector<RunEvent> events_;
  std::string ended_;
  double time_s_ = 0;
  std::optional<std::uint64_t> epoch_;  ///< of the first sample
  std::chrono::steady_clock::time_point progress_due_{};
  unsigned unanswered_ = 0;  ///< lines to the controller that it has not answered
  std::size_t kills_ = 0;    ///< of the controller, so far
  double killed_s_ = 0;      ///< the last one
};

/// Takes samples as often as the wire allows until the run is over.
Outcome<std::string> watch_by_wall_clock(CellConnection& cell, Run& run, Controller* controller,
                                         std::optional<double> speed) {
  for (const auto& done : {cell.set_speed(speed), cell.resume()}) {
    if (!done) return tl::unexpected(done.error());
  }
  const double rate_hz =
      std::min(kMostSamplesPerSecond,
               kSamplesPerSecond * std::max(1.0, speed.value_or(kMostSamplesPerSecond)));
  Outcome<void> restarted;
  const auto watched = cell.stream(rate_hz, [&](const v1::StreamSnapshotsResponse& sample) {
    if (!run.take(sample.snapshot())) return false;
    if (run.kill_is_due()) {
      controller->kill();
      run.controller_killed(sample.snapshot());
      restarted = controller->start();
      if (restarted) run.controller_started(controller->process());
    }
    return restarted.has_value();
  });
  if (!restarted) return tl::unexpected(restarted.error());
  if (!watched) return tl::unexpected(watched.error());
  return std::string();
}

/// Virtual time, from sample to sample.
class SampleTime {
 public:
  explicit SampleTime(CellConnection& cell) : cell_(cell) {}

  /// Goes on from step `now` to the next sample; none when the controller ends instead, or the user
  /// has had enough.
  Outcome<std::optional<v1::Snapshot>> pass(ChildProcess& controller, std::uint64_t now) {
    auto next = ask(now, kStepTime);
    if (!next || *next) return next;
    while (goal_ && !controller.ended() && !interruption::noted()) {
      auto snapshot = look();
      if (!snapshot) return tl::unexpected(snapshot.error());
      if (!goal_ || !snapshot->world_fault().empty()) return std::move(*snapshot);
      static_cast<void>(controller.wait(5ms));
    }
    return std::nullopt;
  }

  /// Lets the CRCL connections of a controller that is gone end, each at the time of its last poll.
  /// Time then stands until another controller is there. A camera's feed notices at its next frame.
  Outcome<void> pass_until_alone(std::uint64_t now, const std::vector<std::string>& roles) {
    const auto deadline = std::chrono::steady_clock::now() + kStartTime;
    while (std::chrono::steady_clock::now() < deadline && !interruption::noted()) {
      if (const auto asked = ask(now, 50ms); !asked) return tl::unexpected(asked.error());
      const auto snapshot = look();
      if (!snapshot) return tl::unexpected(snapshot.error());
      now = snapshot->step();
      const auto& awaited = snapshot->virtual_time().awaited();
      const auto is_awaited = [&](const std::string& role) {
        return !role.starts_with("crcl.") || std::ranges::find(awaited, role) != awaited.end();
      };
      if (std::ranges::all_of(roles, is_awaited)) return {};
      interruption::sleep_until(std::chrono::steady_clock::now() + 5ms);
    }
    return failed(FailureKind::kCheck, "the killed controller's connections do not end");
  }

 private:
  /// For the steps of a sample, if none are asked for: the cell after them, when they have passed
  /// in time.
  Outcome<std::optional<v1::Snapshot>> ask(std::uint64_t now, std::chrono::milliseconds patience) {
    if (goal_) return std::nullopt;
    auto passed = cell_.step_and_look(kVirtualSteps, patience);
    if (passed) return std::move(*passed);
    if (passed.error().kind != FailureKind::kTimeout) return tl::unexpected(passed.error());
    goal_ = now + kVirtualSteps;
    return std::nullopt;
  }

  /// The cell as it is, and whether it has got to where it was asked to.
  Outcome<v1::Snapshot> look() {
    auto snapshot = cell_.snapshot();
    if (!snapshot || !goal_) return snapshot;
    if (snapshot->step() >= *goal_) {
      goal_.reset();
    } else if (std::ranges::count(snapshot->virtual_time().awaited(), "grpc") > 0) {
      return ask_again(std::move(*snapshot));
    }
    return snapshot;
  }

  /// Time stands until it is asked for: the last request was given up before the cell heard of it.
  Outcome<v1::Snapshot> ask_again(v1::Snapshot now) {
    goal_.reset();
    auto passed = ask(now.step(), kStepTime);
    if (!passed) {
      // Or it has been heard of since, and only one may ask at once.
      if (passed.error().kind != FailureKind::kRefused) return tl::unexpected(passed.error());
      goal_ = now.step() + kVirtualSteps;
    }
    return passed && *passed ? std::move(**passed) : std::move(now);
  }

  CellConnection& cell_;
  std::optional<std::uint64_t> goal_;  ///< step that has been asked for and not been reached
};

/// Takes samples in virtual time until the run is over, and lets the controller go home. The hash
/// of the cell's state at the end of the run.
Outcome<std::string> watch_in_virtual_time(CellConnection& cell, Run& run, Controller& controller,
                                           const std::vector<std::string>& roles) {
  std::string hash;
  SampleTime time(cell);
  std::optional<v1::Snapshot> passed_to;
  for (bool over = false; !controller.process().ended() || !over;) {
    auto snapshot = passed_to ? Outcome<v1::Snapshot>(std::move(*passed_to)) : cell.snapshot();
    if (!snapshot) return tl::unexpected(snapshot.error());
    passed_to.reset();
    if (over) {
      run.listen();
    } else if (!run.take(*snapshot)) {
      over = true;
      hash = fmt::format("{:016x}", snapshot->state_hash());
      if (!run.all_submitted()) break;
      controller.process().close_input();
      run.expect_answer();
    } else if (run.kill_is_due()) {
      controller.kill();
      run.controller_killed(*snapshot);
      if (auto alone = time.pass_until_alone(snapshot->step(), roles); !alone) {
        return tl::unexpected(alone.error());
      }
      if (auto started = controller.start(); !started) return tl::unexpected(started.error());
      run.controller_started(controller.process());
      continue;
    }
    run.await_answers();
    auto passed = time.pass(controller.process(), snapshot->step());
    if (!passed) return tl::unexpected(passed.error());
    if (interruption::noted()) break;
    passed_to = std::move(*passed);
  }
  return hash;
}

/// Lets the controller end by itself when it may, else tells it to.
void end_controller(ChildProcess& controller, Run& run) {
  const interruption::Cleanup cleanup;
  controller.close_input();
  const auto deadline = std::chrono::steady_clock::now() + kHomeTime;
  while (run.all_submitted() && !controller.ended() &&
         std::chrono::steady_clock::now() < deadline) {
    run.listen();
    static_cast<void>(controller.wait(50ms));
  }
  if (!controller.ended()) controller.stop(kEndTime);
  run.listen();
}

}  // namespace

Outcome<RunResult> run_scenario(const scenario::Scenario& scenario, const scenario::Plan& plan,
                                const RunOptions& options, const RunListener& listener) {
  const interruption::Hold hold;
  const RunDirectory directory(options.directory);
  const bool waits = options.controller == "none";
  if (options.virtual_time && (waits || options.cell)) {
    return failed(FailureKind::kUsage,
                  "in virtual time the cell and the controller are started by the run");
  }
  const auto roles = roles_of(robots_of(scenario, plan), options.controller.empty());
  auto place = options.cell
                   ? Place{options.cell->endpoints, options.cell->ports_file, {}}
                   : own_place(plan, directory, options.virtual_time ? pacers_of(roles) : "");
  if (!place) return tl::unexpected(place.error());
  // A daemon ends at once when nobody is connected: that of the run is left before it is ended.
  std::optional<CellConnection> connection(std::in_place, place->endpoints);
  CellConnection& cell = *connection;
  if (options.cell) {
    if (auto ready = make_ready(scenario, plan, cell); !ready) return tl::unexpected(ready.error());
  }
  // However a run fails, somebody else's cell goes on.
  const auto fail_with = [&](Failure failure) {
    if (options.cell) static_cast<void>(cell.resume());
    return tl::unexpected(std::move(failure));
  };
  auto description = cell.cell();
  if (!description) return fail_with(description.error());

  std::optional<Controller> controller;
  if (waits) {
    listener.event({0, "waits for a controller; ports: " + place->ports_file});
  } else {
    controller.emplace(controller_command(scenario, options, *place), place->ports_file, directory);
    if (auto started = controller->start(); !started) return fail_with(started.error());
  }

  std::ofstream heard(directory.file("controller.out"));
  Run run(scenario, plan, cell, std::move(*description),
          controller ? &controller->process() : nullptr, options.controller.empty(), heard,
          listener);
  Outcome<std::string> watched;
  if (auto injected = run.inject(); !injected) {
    watched = tl::unexpected(injected.error());
  } else {
    watched =
        options.virtual_time
            ? watch_in_virtual_time(cell, run, *controller, roles)
            : watch_by_wall_clock(cell, run, controller ? &*controller : nullptr, options.speed);
  }
  if (controller && controller->is_there()) end_controller(controller->process(), run);
  const interruption::Cleanup cleanup;
  if (!place->daemon) {
    run.end_faults();
    if (!watched) return fail_with(watched.error());
  } else {
    connection.reset();
    place->daemon->stop(kEndTime);
    if (!watched) {
      return failed(watched.error().kind,
                    watched.error().message + "; " + last_lines(directory.file("aprsimd.log")));
    }
  }
  if (interruption::happened()) return failed(FailureKind::kInterrupted, "interrupted");
  RunResult result = run.result();
  result.state_hash = *watched;
  result.controller = options.controller.empty() ? "kitting" : options.controller;
  return result;
}

}  // namespace aprsim::client
