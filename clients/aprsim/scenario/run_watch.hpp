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

/// The event that a controller's line tells of; empty = none.
[[nodiscard]] std::string event_of(const std::string& line);

/// Watches one run from the first sample to its stop condition: orders, faults, what the controller
/// says, measures. All that it is given outlives it. Thread: one.
class RunWatch {
 public:
  /// `controller`: null when it is not ours; `speaks`: it says what it does; `heard`: takes all
  /// that it says.
  RunWatch(const scenario::Scenario& scenario, const scenario::Plan& plan, CellConnection& cell,
           v1::CellDescription description, process::ChildProcess* controller, bool speaks,
           std::ostream& heard, const RunListener& listener);

  [[nodiscard]] Outcome<void> inject();
  /// Of the faults that it has injected none is left. Those that are over already cannot be ended.
  void end_faults();

  /// The next sample; false when the run is over.
  [[nodiscard]] bool take(const v1::Snapshot& snapshot);
  /// In virtual time: until the controller has taken in all that it has been told; time stands
  /// meanwhile.
  void await_answers();
  void expect_answer() { ++unanswered_; }
  /// What the controller says while it ends.
  void listen();
  /// Takes what the controller says without hearing it yet: that is for the next sample. Whether
  /// the run can go no further: it has ended, or in a run without orders said "end".
  [[nodiscard]] bool prick_up();
  /// That it has said "end", after which it does nothing more in this run.
  [[nodiscard]] bool controller_has_ended() const { return said_end_; }
  /// That it has said "ready".
  [[nodiscard]] bool controller_is_ready() const { return said_ready_; }
  /// Without a further sample, since there is none: what has been heard ends the run.
  void end_with_controller();

  [[nodiscard]] RunResult result() const;

  /// Whether the controller is to be killed now.
  [[nodiscard]] bool kill_is_due() const;
  /// It is gone; what it has said is heard first.
  void controller_killed(const v1::Snapshot& snapshot);
  /// One that knows nothing: all orders that still hold are announced to it.
  void controller_started(process::ChildProcess& controller);

  [[nodiscard]] bool all_submitted() const;
  /// The controller has done its job, or what it was told to.
  [[nodiscard]] bool ended_in_order() const;
  [[nodiscard]] std::uint64_t last_step() const { return last_step_; }

 private:
  bool end(const std::string& why);
  void note(const std::string& what);
  void note_faults(const Sample& sample);
  [[nodiscard]] bool has_come(const scenario::Moment& moment) const;
  void report(const std::string& order, const char* what);
  void announce(const scenario::Order& order);
  void send(const nlohmann::ordered_json& message);
  void move_orders_on();
  void hear(const std::string& line);
  void hear_submission(const nlohmann::json& message, const std::string& line);
  void submit(const std::string& order, const std::optional<Eigen::Vector2d>& place);
  /// For a controller that does not say when it is done.
  void submit_silently();
  void tell_progress(bool at_once);
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
  std::vector<std::string> waiting_;  ///< lines that are to be heard with the next sample
  bool end_waits_ = false;            ///< among them, or heard
  std::map<std::string, std::uint64_t> fault_ids_;
  std::vector<std::uint64_t> injected_;
  std::set<std::uint64_t> begun_, over_;
  std::set<std::string> announced_, cancelled_;
  std::vector<RunEvent> events_;
  std::string ended_;
  double time_s_ = 0;
  std::uint64_t last_step_ = 0;
  std::optional<std::uint64_t> epoch_;  ///< of the first sample
  std::chrono::steady_clock::time_point progress_due_{};
  unsigned unanswered_ = 0;  ///< lines to the controller that it has not answered
  bool said_end_ = false, said_ready_ = false;
  std::size_t kills_ = 0;  ///< of the controller, so far
  double killed_s_ = 0;    ///< the last one
};

}  // namespace aprsim::client
