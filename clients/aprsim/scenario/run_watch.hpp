#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "aprsim/v1/cell.pb.h"
#include "aprsim/v1/snapshot.pb.h"
#include "clients/aprsim/scenario/measures.hpp"
#include "clients/aprsim/scenario/runner.hpp"
#include "clients/wires/cell_connection.hpp"
#include "world/base/process/child_process.hpp"

namespace aprsim::client {

/// The event that a controller's line reports; empty = none.
[[nodiscard]] std::string event_of(const std::string& line);

/// Follows one run from the first sample to its stop condition: orders, faults, the controller's
/// output, measures. All arguments outlive it. Thread: one.
class RunWatch {
 public:
  /// `controller`: null when it was started elsewhere; `speaks`: it reports its progress;
  /// `heard`: receives all its lines.
  RunWatch(const scenario::Scenario& scenario, const scenario::Plan& plan, CellConnection& cell,
           v1::CellDescription description, process::ChildProcess* controller, bool speaks,
           std::ostream& heard, const RunListener& listener);

  [[nodiscard]] Outcome<void> inject();
  /// Ends all faults that the run injected. Faults that are over already cannot be ended.
  void end_faults();

  /// The next sample; false when the run is over.
  [[nodiscard]] bool accept(const v1::Snapshot& snapshot);
  /// Waits until the controller has answered all lines sent to it; virtual time does not advance
  /// meanwhile. Does not wait again for a controller that never reported anything. Failure:
  /// timeout.
  [[nodiscard]] Outcome<void> await_answers(std::chrono::seconds patience);
  void expect_answer() { unanswered_ += is_silent_ ? 0 : 1; }
  /// Reads the last lines of a controller that ends.
  void listen();
  /// Reads the controller's lines and keeps them for the next sample. Returns whether the run
  /// cannot continue: the controller has exited, or reported "end" in a run without orders.
  [[nodiscard]] bool read_ahead();
  /// Whether it has reported "end" and does nothing more in this run.
  [[nodiscard]] bool controller_has_ended() const { return said_end_; }
  /// Whether it has reported "ready".
  [[nodiscard]] bool controller_is_ready() const { return said_ready_; }
  /// Ends the run by the lines read, without a further sample.
  void end_with_controller();

  [[nodiscard]] RunResult result() const;

  /// Whether the controller is to be killed now.
  [[nodiscard]] bool kill_is_due() const;
  /// Notes that the controller was killed; its last lines count first.
  void controller_killed(const v1::Snapshot& snapshot);
  /// Announces all open orders to a restarted controller.
  void controller_started(process::ChildProcess& controller);

  [[nodiscard]] bool all_submitted() const;
  /// Whether the controller has finished its job.
  [[nodiscard]] bool ended_in_order() const;
  [[nodiscard]] std::uint64_t last_step() const { return last_step_; }

 private:
  bool end(const std::string& why);
  void record_event(const std::string& what);
  void record_faults(const Sample& sample);
  [[nodiscard]] bool has_come(const scenario::Moment& moment) const;
  void report(const std::string& order, const char* what);
  void announce(const scenario::Order& order);
  void send(const nlohmann::ordered_json& message);
  void move_orders_on();
  void process_line(const std::string& line);
  void process_submission(const nlohmann::json& message, const std::string& line);
  void submit(const std::string& order, const std::optional<Eigen::Vector2d>& place);
  /// For a controller that does not say when it is done.
  void submit_silently();
  void report_progress(bool at_once);
  [[nodiscard]] bool all_done() const;
  [[nodiscard]] bool go_on();

  const scenario::Scenario& scenario_;
  const scenario::Plan& plan_;
  CellConnection& cell_;
  v1::CellDescription description_;
  process::ChildProcess* controller_;
  bool speaks_;
  std::ostream& heard_;
  const RunListener& listener_;
  Measures measures_;
  ControllerWords words_;
  std::vector<std::string> waiting_;  ///< lines to be processed with the next sample
  bool end_waits_ = false;            ///< among them, or heard
  std::map<std::string, std::uint64_t> fault_ids_;
  std::vector<std::uint64_t> injected_;
  std::set<std::uint64_t> begun_, over_;
  std::set<std::string> announced_, cancelled_;
  std::vector<RunEvent> events_;
  std::string end_reason_;
  double time_s_ = 0;
  std::uint64_t last_step_ = 0;
  std::optional<std::uint64_t> epoch_;  ///< of the first sample
  std::chrono::steady_clock::time_point progress_due_{};
  unsigned unanswered_ = 0;  ///< lines to the controller that it has not answered
  std::string last_sent_;    ///< the latest of them
  bool is_silent_ = false;   ///< it never reported anything and is not waited for
  bool said_end_ = false, said_ready_ = false;
  std::size_t kills_ = 0;  ///< of the controller, so far
  double killed_s_ = 0;    ///< the last one
};

}  // namespace aprsim::client
