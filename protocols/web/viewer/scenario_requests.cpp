#include "protocols/web/viewer/scenario_requests.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "protocols/web/topics/topic_table.hpp"

namespace aprsim::web {
namespace {

constexpr std::size_t kLongestName = 64;

Result<void> check_offered(const ScenarioDrafts* drafts) {
  if (drafts != nullptr) return {};
  return fail(ErrorCode::kFailedPrecondition, "scenario",
              "this daemon edits no scenario: it replays a run");
}

bool is_name(const std::string& name) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  };
  return !name.empty() && name.size() <= kLongestName && name.front() != '.' &&
         name.front() != '-' && std::ranges::all_of(name, fits);
}

}  // namespace

Result<void> ScenarioRequests::write_source(const std::string& name, v1::ScenarioSource& message) {
  if (auto offered = check_offered(options_.scenarios); !offered) return offered;
  auto source = options_.scenarios->find(name);
  if (!source) return tl::unexpected(std::move(source.error()));
  message.set_text(source->text);
  message.set_scene(source->scene);
  for (const std::string& known : source->names) message.add_names(known);
  return {};
}

Result<void> ScenarioRequests::check(std::uint64_t viewer, const v1::ViewerRequest& request) {
  if (auto offered = check_offered(options_.scenarios); !offered) return offered;
  const bool runs = request.has_run_scenario();
  if (runs && options_.programs == nullptr) {
    return fail(ErrorCode::kFailedPrecondition, "programs", no_programs()->refusal);
  }
  if (runs && !is_name(request.run_scenario().name())) {
    return fail(ErrorCode::kInvalidArgument, "name",
                "the name of a scenario has 1 to 64 letters, digits, '_', '-' and '.', and begins "
                "with a letter, a digit or '_'");
  }
  if (!pending_.insert(viewer).second) {
    return fail(ErrorCode::kUnavailable, "scenario", "the last check is still running");
  }
  const std::string& text = runs ? request.run_scenario().text() : request.check_scenario().text();
  options_.scenarios->check(text,
                            [mailbox = mailbox_, viewer, request](Result<ScenarioCheck> check) {
                              const std::lock_guard lock(mailbox->mutex);
                              mailbox->answers.push_back({viewer, request, std::move(check)});
                            });
  return {};
}

std::vector<ScenarioRequests::Answer> ScenarioRequests::take_answers() {
  std::vector<Answer> answers;
  {
    const std::lock_guard lock(mailbox_->mutex);
    answers.swap(mailbox_->answers);
  }
  for (const Answer& answer : answers) pending_.erase(answer.viewer);
  return answers;
}

void ScenarioRequests::write(const Answer& answer, v1::ScenarioCheck& message) {
  const ScenarioCheck& check = *answer.check;
  message.set_id(answer.request.id());
  for (const Error& problem : check.problems) {
    auto& out = *message.add_problems();
    out.set_key(problem.field);
    out.set_message(problem.message);
  }
  message.set_run_refusal(check.run_refusal);
  message.set_kits(check.kits);
  message.set_faults(static_cast<std::uint32_t>(check.faults));
  message.set_time_limit_s(check.time_limit_s);
}

Result<void> ScenarioRequests::run(const Answer& answer) {
  if (!answer.check) return tl::unexpected(answer.check.error());
  if (!answer.check->problems.empty()) return tl::unexpected(answer.check->problems.front());
  if (!answer.check->run_refusal.empty()) {
    return fail(ErrorCode::kFailedPrecondition, "scenario", answer.check->run_refusal);
  }
  const v1::RunScenario& wanted = answer.request.run_scenario();
  return options_.programs->start_scenario(
      wanted.name(), wanted.text(),
      wanted.has_seed() ? std::optional(wanted.seed()) : std::nullopt);
}

}  // namespace aprsim::web
