#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "aprsim/v1/web.pb.h"
#include "protocols/ports/scenario_drafts.hpp"
#include "protocols/web/viewer/web_options.hpp"

namespace aprsim::web {

/// Viewers' requests to edit scenarios and to run them, one check of each viewer at a time. Thread:
/// the server's.
class ScenarioRequests {
 public:
  struct Answer {
    std::uint64_t viewer = 0;
    v1::ViewerRequest request;  ///< check_scenario or run_scenario
    Result<ScenarioCheck> check;
  };

  /// `options` must outlive this object.
  explicit ScenarioRequests(const WebServerOptions& options) : options_(options) {}

  /// Writes the text of a shipped scenario. Errors: kFailedPrecondition where none is edited;
  /// kNotFound.
  [[nodiscard]] Result<void> write_source(const std::string& name, v1::ScenarioSource& message);
  /// Begins the check that each request begins with. Errors: kFailedPrecondition where no scenario
  /// is edited or no program is started; kInvalidArgument for a name that is none; kUnavailable
  /// while the viewer's last check is running.
  [[nodiscard]] Result<void> check(std::uint64_t viewer, const v1::ViewerRequest& request);
  /// Answers since the last call.
  [[nodiscard]] std::vector<Answer> take_answers();
  static void write(const Answer& answer, v1::ScenarioCheck& message);
  /// Runs the scenario of run_scenario if its check permits. Errors: the first problem; the reason
  /// why it cannot run here; as ProgramRunner::start_scenario.
  [[nodiscard]] Result<void> run(const Answer& answer);
  void forget(std::uint64_t viewer) { pending_.erase(viewer); }

 private:
  /// Outlives this object while an answer is pending.
  struct Mailbox {
    std::mutex mutex;
    std::vector<Answer> answers;
  };

  const WebServerOptions& options_;
  std::shared_ptr<Mailbox> mailbox_ = std::make_shared<Mailbox>();
  std::set<std::uint64_t> pending_;  ///< viewers
};

}  // namespace aprsim::web
