#include "clients/aprsim/scenario/run_watch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/scenario/sampler.hpp"
#include "clients/aprsim/scenario/scores.hpp"
#include "clients/aprsim/text/fault_request.hpp"
#include "world/base/utf8.hpp"

namespace aprsim::client {
namespace {

using namespace std::chrono_literals;
using process::ChildProcess;

constexpr auto kSilence = 60s;  // without any line, after which a controller counts as silent
constexpr auto kProgressPeriod = 500ms;  // between two progress reports
constexpr const char* kAllSubmitted = "all orders were submitted";
constexpr const char* kControllerDone = "the controller is done";

FaultInjectCommand command_of(const scenario::Fault& fault) {
  FaultInjectCommand out{.kind = fault.kind,
                         .target = fault.target,
                         .parameters = fault.parameters,
                         .when = fault.when,
                         .for_s = fault.for_s};
  if (fault.at_s) out.at_s = fault.at_s->front();
  return out;
}

/// Describes the activity of the cell.
std::string activity_of(const v1::Snapshot& snapshot) {
  std::string out;
  for (const auto& robot : snapshot.robots()) {
    out += (out.empty() ? "" : ", ") + robot.name() + (robot.moving() ? " moves" : " is at rest");
    if (robot.gripper().holding() && robot.gripper().has_held_index()) {
      out += " with " + snapshot.bodies(static_cast<int>(robot.gripper().held_index())).name();
    } else if (robot.gripper().setting() < 0.5) {
      out += ", commanded to grip";
    }
  }
  return out + (std::abs(snapshot.conveyor().speed_m_s()) > 1e-4 ? ", the belt runs" : "");
}

}  // namespace

std::string event_of(const std::string& line) {
  const auto message = nlohmann::json::parse(line, nullptr, /*allow_exceptions=*/false);
  const bool tells = message.is_object() && message.contains("event");
  return tells && message["event"].is_string() ? message["event"].get<std::string>()
                                               : std::string();
}

RunWatch::RunWatch(const scenario::Scenario& scenario, const scenario::Plan& plan,
                   CellConnection& cell, v1::CellDescription description, ChildProcess* controller,
                   bool speaks, std::ostream& heard, const RunListener& listener)
    : scenario_(scenario),
      plan_(plan),
      cell_(cell),
      description_(std::move(description)),
      controller_(controller),
      speaks_(speaks),
      heard_(heard),
      listener_(listener),
      measures_(shape_of(description_), scenario.orders) {}

Outcome<void> RunWatch::inject() {
  for (const scenario::Fault& fault : plan_.faults) {
    const auto taken = cell_.inject_fault(fault_request(command_of(fault)));
    if (!taken) return tl::unexpected(taken.error());
    injected_.push_back(taken->fault().id());
    if (!fault.name.empty()) fault_ids_[fault.name] = taken->fault().id();
  }
  return {};
}

void RunWatch::end_faults() {
  for (const std::uint64_t id : injected_) static_cast<void>(cell_.end_fault(id));
}

bool RunWatch::accept(const v1::Snapshot& snapshot) {
  if (interruption::requested()) return end("interrupted");
  if (!snapshot.world_fault().empty()) return end("the cell stopped: " + snapshot.world_fault());
  if (epoch_.value_or(snapshot.epoch()) != snapshot.epoch()) {
    return end("another client has reset the cell");
  }
  epoch_ = snapshot.epoch();
  last_step_ = snapshot.step();
  const Sample sample = sample_of(snapshot, description_);
  time_s_ = sample.time_s;
  measures_.add(sample);
  record_faults(sample);
  move_orders_on();
  listen();
  submit_silently();
  const bool goes_on = go_on();
  report_progress(!goes_on);
  return goes_on;
}

Outcome<void> RunWatch::await_answers(std::chrono::seconds patience) {
  const auto began = std::chrono::steady_clock::now();
  while (controller_ != nullptr && unanswered_ > 0 && !controller_->ended() &&
         !interruption::requested()) {
    listen();
    if (unanswered_ == 0) break;
    const auto waited = std::chrono::steady_clock::now() - began;
    if (!speaks_ && waited > std::min<std::chrono::seconds>(kSilence, patience)) {
      record_event("the controller reports nothing; the run continues without its answers");
      is_silent_ = true;
      unanswered_ = 0;
    } else if (waited > patience) {
      return failed(FailureKind::kCheck,
                    fmt::format("waited {} s for the controller to answer {}", patience.count(),
                                last_sent_.empty() ? "the end of the orders" : last_sent_));
    }
    static_cast<void>(controller_->wait(1ms));
  }
  return {};
}

void RunWatch::listen() {
  static_cast<void>(read_ahead());
  for (const std::string& line : std::exchange(waiting_, {})) process_line(line);
}

bool RunWatch::read_ahead() {
  if (controller_ == nullptr) return false;
  for (std::string& line : controller_->lines()) {
    end_waits_ = end_waits_ || event_of(line) == "end";
    waiting_.push_back(std::move(line));
  }
  return controller_->ended().has_value() || (end_waits_ && scenario_.orders.empty());
}

void RunWatch::end_with_controller() {
  listen();
  if (go_on()) end("the controller makes no progress");
  report_progress(/*at_once=*/true);
}

RunResult RunWatch::result() const {
  RunResult out{.scenario = scenario_.name,
                .description = scenario_.description,
                .seed = plan_.seed,
                .end_reason = end_reason_,
                .measured = measures_.result(words_),
                .events = events_};
  if (!plan_.kills_s.empty()) out.measured.values["controller_kills"] = static_cast<double>(kills_);
  if (kills_ > 0) out.measured.values["controller_killed_s"] = killed_s_;
  add_scores(out.measured, scenario_.scoring);
  out.verdicts = judge(out.measured, scenario_.expected);
  return out;
}

bool RunWatch::kill_is_due() const {
  return controller_ != nullptr && kills_ < plan_.kills_s.size() &&
         time_s_ >= plan_.kills_s[kills_];
}

void RunWatch::controller_killed(const v1::Snapshot& snapshot) {
  listen();
  controller_ = nullptr;
  unanswered_ = 0;
  ++kills_;
  killed_s_ = time_s_;
  record_event("the controller is killed and started again; " + activity_of(snapshot));
}

void RunWatch::controller_started(ChildProcess& controller) {
  controller_ = &controller;
  for (const scenario::Order& order : scenario_.orders) {
    if (announced_.contains(order.name) && !cancelled_.contains(order.name)) announce(order);
  }
}

bool RunWatch::all_submitted() const { return end_reason_ == kAllSubmitted; }

bool RunWatch::ended_in_order() const { return all_submitted() || end_reason_ == kControllerDone; }

bool RunWatch::end(const std::string& why) {
  end_reason_ = why;
  return false;
}

void RunWatch::record_event(const std::string& what) {
  events_.push_back({time_s_, what});
  listener_.event(events_.back());
}

void RunWatch::record_faults(const Sample& sample) {
  for (const FaultSample& fault : sample.faults) {
    const std::string name = fault.kind + (fault.target.empty() ? "" : " ") + fault.target;
    if (fault.begin_s && begun_.insert(fault.id).second) record_event("fault begins: " + name);
    if (fault.begin_s && fault.end_s && *fault.end_s > *fault.begin_s &&
        over_.insert(fault.id).second) {
      record_event("fault ends: " + name);
    }
  }
}

bool RunWatch::has_come(const scenario::Moment& moment) const {
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

void RunWatch::report(const std::string& order, const char* what) {
  record_event(fmt::format("{}: {}", what, order));
  // Faults may wait for the event; a dead daemon is detected elsewhere.
  static_cast<void>(cell_.report_event(std::string("order-") + what));
  static_cast<void>(cell_.report_event(order + '-' + what));
}

void RunWatch::send(const nlohmann::ordered_json& message) {
  if (controller_ == nullptr) return;
  last_sent_ = message.dump();
  controller_->write_line(last_sent_);
  expect_answer();
}

void RunWatch::announce(const scenario::Order& order) {
  send({{"announce", order.name},
        {"tray", order.tray},
        {"count", order.count},
        {"priority", order.priority},
        {"slots", order.slots}});
}

void RunWatch::move_orders_on() {
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

void RunWatch::process_line(const std::string& line) {
  heard_ << line << std::endl;
  const auto message = nlohmann::json::parse(line, nullptr, /*allow_exceptions=*/false);
  if (!message.is_object()) return;
  speaks_ = true;
  is_silent_ = false;
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
  if (event == "end") {
    said_end_ = true;
    said_ready_ = false;  // it was, before
  }
  if (event == "ready") said_ready_ = true;
  if (event == "submit") process_submission(message, line);
}

void RunWatch::process_submission(const nlohmann::json& message, const std::string& line) {
  const auto order = message.find("order");
  if (order == message.end() || !order->is_string() ||
      !announced_.contains(order->get<std::string>())) {
    record_event(fmt::format("the controller submits an unknown order: {}", utf8::cut(line, 200)));
    return;
  }
  std::optional<Eigen::Vector2d> place;
  if (message.contains("x_m") && message.contains("y_m") && message["x_m"].is_number() &&
      message["y_m"].is_number()) {
    place = Eigen::Vector2d(message["x_m"].get<double>(), message["y_m"].get<double>());
  }
  submit(order->get<std::string>(), place);
}

void RunWatch::submit(const std::string& order, const std::optional<Eigen::Vector2d>& place) {
  if (measures_.submitted(order, place)) report(order, "submitted");
}

void RunWatch::submit_silently() {
  if (speaks_) return;
  for (const std::string& order : announced_) {
    for (unsigned i = std::min(measures_.open(order), measures_.fulfilled(order)); i > 0; --i) {
      submit(order, {});
    }
  }
}

void RunWatch::report_progress(bool at_once) {
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

bool RunWatch::all_done() const {
  return std::ranges::all_of(scenario_.orders, [&](const scenario::Order& order) {
    return announced_.contains(order.name) && measures_.open(order.name) == 0;
  });
}

bool RunWatch::go_on() {
  const bool has_orders = !scenario_.orders.empty();
  if (has_orders && scenario_.stop.orders_submitted && all_done()) return end(kAllSubmitted);
  if (!has_orders && said_end_) return end(kControllerDone);
  if (time_s_ >= scenario_.stop.time_limit_s) return end("the time limit was reached");
  if (scenario_.stop.quiet_s && measures_.quiet_s() >= *scenario_.stop.quiet_s) {
    return end("nothing moved");
  }
  if (controller_ != nullptr && controller_->ended()) {
    listen();
    return end(fmt::format("the controller ended with {}", *controller_->ended()));
  }
  return true;
}

}  // namespace aprsim::client
