#include "protocols/web/viewer/viewer_requests.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "protocols/messages/history_message.hpp"
#include "protocols/messages/preview_message.hpp"
#include "protocols/ports/command_failure.hpp"
#include "protocols/web/topics/register_view.hpp"
#include "protocols/web/topics/topic_table.hpp"
#include "protocols/web/viewer/request_record.hpp"
#include "protocols/web/viewer/viewer_command.hpp"
#include "world/api/description/robot_identity.hpp"

namespace aprsim::web {
namespace {

bool concerns_faults(const v1::ViewerRequest& request) {
  return request.has_inject_fault() || request.has_end_fault() || request.has_report_event();
}

bool resets_to_scene(const v1::ViewerRequest& request) {
  return request.reset().scene_case() != v1::ResetRequest::SCENE_NOT_SET;
}

/// Whether the outcome is read from the snapshot in which the command has been applied.
bool is_awaited(const v1::ViewerRequest& request) {
  return concerns_faults(request) || resets_to_scene(request);
}

bool concerns_scenarios(const v1::ViewerRequest& request) {
  return request.has_get_scenario() || request.has_check_scenario() || request.has_run_scenario();
}

/// Whether the answer comes later, or is another message than an outcome.
bool answered_otherwise(const v1::ViewerRequest& request) {
  return request.jog().step() != 0 || request.has_past() || request.has_resume_from() ||
         request.has_preview() || request.has_get_scene() || request.has_draft_scene() ||
         concerns_scenarios(request) || is_awaited(request);
}

void send_outcome(Viewer& viewer, std::uint32_t id, const Result<void>& done) {
  if (id == 0) return;
  v1::ViewerUpdate update;
  auto& outcome = *update.mutable_outcome();
  outcome.set_id(id);
  outcome.set_ok(done.has_value());
  if (!done) {
    outcome.set_field(done.error().field);
    outcome.set_message(done.error().message);
  }
  const WebMessage message = pack(update);
  viewer.trace.sent(*message);
  viewer.send(message);
}

}  // namespace

ViewerRequests::ViewerRequests(Context context, Events events)
    : context_(context),
      events_(std::move(events)),
      past_(context.options, context.instance_id),
      previews_(context.options.previews),
      drafts_(context.options, context.instance_id),
      scenarios_(context.options) {
  follow_robots(context_.source.latest()->cell);
}

/// Jogs end where a reset has brought other robots.
void ViewerRequests::follow_robots(const std::shared_ptr<const api::CellDescription>& cell) {
  if (cell == cell_) return;
  const bool same =
      cell_ && std::ranges::equal(cell->robots, cell_->robots, [](const auto& a, const auto& b) {
        return api::same_robot(a, b);
      });
  cell_ = cell;
  if (same) return;
  for (Jogger& jogger : joggers_) {
    jogger.abandon();
    answer_steps(jogger);
  }
  joggers_.clear();
  for (int robot = 0; robot < static_cast<int>(cell->robots.size()); ++robot) {
    joggers_.emplace_back(robot, context_.options.listener.endpoint, context_.sink,
                          context_.options.jog_timeout, cell);
  }
}

void ViewerRequests::answer_steps(Jogger& jogger) {
  for (const auto& step : jogger.take_ended()) {
    if (const auto viewer = context_.viewers.find(step.viewer)) {
      send_outcome(*viewer, step.id, step.outcome);
    }
  }
}

void ViewerRequests::answer(Viewer& viewer, const v1::ViewerRequest& request) {
  const auto asked = Clock::now();
  ++context_.counts.requests;
  const auto done = execute(viewer, request);
  if (done && answered_otherwise(request)) return;
  context_.counts.answered(Clock::now() - asked, done.has_value());
  send_outcome(viewer, request.id(), done);
}

Result<void> ViewerRequests::execute(Viewer& viewer, const v1::ViewerRequest& request) {
  if (request.has_authenticate()) return authenticate(viewer, request.authenticate().token());
  const auto allowed = context_.access.check_role(viewer, kind_of(request));
  if (request.has_watch()) {
    if (allowed) events_.watch(viewer, request.watch());
    return allowed;
  }
  if (request.has_past()) return allowed ? *past_.execute(viewer, request) : allowed;
  if (request.has_preview()) {
    return allowed ? previews_.ask(viewer.id(), request, *context_.source.latest()) : allowed;
  }
  if (request.has_get_scene()) return allowed ? send_scene(viewer, request.id()) : allowed;
  if (request.has_draft_scene()) {
    const auto& name = context_.source.latest()->cell->scene;
    return allowed ? drafts_.build(viewer.id(), request, name) : allowed;
  }
  if (concerns_scenarios(request)) return execute_scenario(viewer, request, allowed);
  const auto done = allowed ? command(viewer, request) : allowed;
  record(context_.options, *context_.source.latest()->cell, viewer, request, done);
  return done;
}

Result<void> ViewerRequests::authenticate(Viewer& viewer, const std::string& token) {
  if (!context_.options.listener.access->has_credentials()) return {};
  const auto done = context_.access.authenticate(viewer, token);
  if (done) events_.authenticated(viewer);
  return done;
}

Result<void> ViewerRequests::command(Viewer& viewer, const v1::ViewerRequest& request) {
  if (request.has_write_register()) return write_register(request.write_register());
  if (request.has_start_program() || request.has_stop_program()) return command_programs(request);
  if (const auto done = past_.execute(viewer, request)) return *done;
  if (request.has_jog()) return jog(viewer, request);
  return command_world(viewer, request);
}

Result<void> ViewerRequests::command_world(const Viewer& viewer, const v1::ViewerRequest& request) {
  const api::SnapshotPtr now = context_.source.latest();
  const auto commands = commands_of(request, *now);
  if (!commands) return fail(ErrorCode::kUnimplemented, "body", "unknown request");
  if (!*commands) return tl::unexpected(commands->error());
  // Submit all even after an error, so that a stop of the cell stops as much as possible.
  Result<void> done;
  for (const auto& body : **commands) {
    const auto ticket = context_.sink.submit({context_.options.listener.endpoint, body, now->cell});
    if (!ticket && done) done = tl::unexpected(ticket.error());
    if (ticket && is_awaited(request)) {
      awaited_.push_back({viewer.id(), request.id(), *ticket, Clock::now()});
    }
  }
  return done;
}

Result<void> ViewerRequests::command_programs(const v1::ViewerRequest& request) {
  ProgramRunner* const programs = context_.options.programs;
  if (programs == nullptr) {
    return fail(ErrorCode::kFailedPrecondition, "programs", no_programs()->refusal);
  }
  if (request.has_stop_program()) return programs->stop();
  const v1::StartProgram& start = request.start_program();
  return programs->start(start.name(),
                         start.has_seed() ? std::optional(start.seed()) : std::nullopt);
}

Result<void> ViewerRequests::write_register(const v1::WriteRegister& write) {
  const auto checked = to_register_write(write);
  if (!checked) return tl::unexpected(checked.error());
  context_.device.refresh();
  const auto ticket = context_.device.write(checked->request());
  if (ticket) return {};
  switch (ticket.error()) {
    case modbus::ExceptionCode::kServerDeviceBusy:
      return fail(ErrorCode::kUnavailable, "value",
                  "the simulation's command queue is full; try again");
    case modbus::ExceptionCode::kServerDeviceFailure:
      return fail(ErrorCode::kFailedPrecondition, "value", "this cell has no conveyor");
    default:
      return fail(ErrorCode::kInvalidArgument, "value",
                  fmt::format("{}: not written (Modbus exception {})", write.value(),
                              static_cast<int>(ticket.error())));
  }
}

Result<void> ViewerRequests::jog(const Viewer& viewer, const v1::ViewerRequest& request) {
  const v1::JogRequest& jog = request.jog();
  const api::SnapshotPtr snapshot = context_.source.latest();
  follow_robots(snapshot->cell);
  if (jog.robot() >= joggers_.size()) {
    return fail(ErrorCode::kNotFound, "robot",
                fmt::format("{} is not below {}", jog.robot(), joggers_.size()));
  }
  Jogger& jogger = joggers_[jog.robot()];
  if (jog.step() != 0) return jogger.step(viewer.id(), request.id(), jog, *snapshot);
  return jogger.renew(viewer.id(), jog, *snapshot, Clock::now());
}

void ViewerRequests::tick_jogs(const api::Snapshot& snapshot, Clock::time_point now) {
  follow_robots(snapshot.cell);
  for (Jogger& jogger : joggers_) {
    jogger.tick(snapshot, now);
    answer_steps(jogger);
  }
}

void ViewerRequests::answer_waiting(const api::Snapshot& snapshot) {
  answer_awaited(snapshot);
  for (const PastRequests::Answer& answer : past_.take_answers()) answer_past(answer);
  for (const PreviewRequests::Answer& answer : previews_.take_answers()) answer_preview(answer);
  for (const DraftRequests::Answer& answer : drafts_.take_answers()) answer_draft(answer);
  for (const auto& answer : scenarios_.take_answers()) answer_scenario(answer);
}

void ViewerRequests::answer_awaited(const api::Snapshot& snapshot) {
  std::vector<Awaited> due;
  std::erase_if(awaited_, [&](const Awaited& awaited) {
    if (awaited.ticket > snapshot.applied) return false;
    due.push_back(awaited);
    return true;
  });
  for (const Awaited& awaited : due) {
    const auto viewer = context_.viewers.find(awaited.viewer);
    if (!viewer) continue;
    const Error* error = protocols::failure_of(snapshot, awaited.ticket);
    context_.counts.answered(Clock::now() - awaited.asked, error == nullptr);
    send_outcome(*viewer, awaited.request, error ? tl::unexpected(*error) : Result<void>());
  }
}

void ViewerRequests::answer_past(const PastRequests::Answer& answer) {
  const auto viewer = context_.viewers.find(answer.query.viewer);
  if (!viewer) return;
  if (!answer.past) {
    send_outcome(*viewer, answer.query.request, tl::unexpected(answer.past.error()));
  } else if (answer.query.resume) {
    resume(answer, *viewer);
  } else {
    v1::ViewerUpdate update;
    past_.write(answer, *context_.source.latest()->cell, *update.mutable_past());
    viewer->send(update);
  }
}

void ViewerRequests::answer_preview(const PreviewRequests::Answer& answer) {
  const auto viewer = context_.viewers.find(answer.viewer);
  if (!viewer) return;
  if (!answer.preview) {
    return send_outcome(*viewer, answer.request, tl::unexpected(answer.preview.error()));
  }
  v1::ViewerUpdate update;
  update.mutable_preview()->set_id(answer.request);
  protocols::write_message(*answer.preview, *update.mutable_preview()->mutable_plan());
  viewer->send(update);
}

Result<void> ViewerRequests::send_scene(Viewer& viewer, std::uint32_t id) {
  v1::ViewerUpdate update;
  update.mutable_scene()->set_id(id);
  const auto written =
      drafts_.write_source(*context_.source.latest()->cell, *update.mutable_scene());
  if (written) viewer.send(update);
  return written;
}

void ViewerRequests::answer_draft(const DraftRequests::Answer& answer) {
  const auto viewer = context_.viewers.find(answer.viewer);
  if (!viewer) return;
  if (!answer.draft) {
    return send_outcome(*viewer, answer.request, tl::unexpected(answer.draft.error()));
  }
  v1::ViewerUpdate update;
  drafts_.write(answer, *update.mutable_draft());
  viewer->send(update);
}

/// A run is recorded with its outcome.
Result<void> ViewerRequests::execute_scenario(Viewer& viewer, const v1::ViewerRequest& request,
                                              Result<void> done) {
  if (request.has_get_scenario()) return done ? send_scenario(viewer, request) : done;
  if (done) done = scenarios_.check(viewer.id(), request);
  if (!done && request.has_run_scenario()) {
    record(context_.options, *context_.source.latest()->cell, viewer, request, done);
  }
  return done;
}

Result<void> ViewerRequests::send_scenario(Viewer& viewer, const v1::ViewerRequest& request) {
  v1::ViewerUpdate update;
  update.mutable_scenario()->set_id(request.id());
  const auto written =
      scenarios_.write_source(request.get_scenario().name(), *update.mutable_scenario());
  if (written) viewer.send(update);
  return written;
}

void ViewerRequests::answer_scenario(const ScenarioRequests::Answer& answer) {
  const auto viewer = context_.viewers.find(answer.viewer);
  if (!viewer) return;
  if (answer.request.has_run_scenario()) {
    const auto done = scenarios_.run(answer);
    record(context_.options, *context_.source.latest()->cell, *viewer, answer.request, done);
    return send_outcome(*viewer, answer.request.id(), done);
  }
  if (!answer.check) {
    return send_outcome(*viewer, answer.request.id(), tl::unexpected(answer.check.error()));
  }
  v1::ViewerUpdate update;
  ScenarioRequests::write(answer, *update.mutable_scenario_check());
  viewer->send(update);
}

void ViewerRequests::resume(const PastRequests::Answer& answer, Viewer& viewer) {
  const auto ticket = context_.sink.submit(
      {context_.options.listener.endpoint,
       api::SimulationCommand(protocols::resumption(answer.query.moment, *answer.past))});
  if (ticket) {
    awaited_.push_back({answer.query.viewer, answer.query.request, *ticket, Clock::now()});
  } else {
    send_outcome(viewer, answer.query.request, tl::unexpected(ticket.error()));
  }
}

void ViewerRequests::release_jogs(const Viewer& viewer) {
  for (Jogger& jogger : joggers_) jogger.release(viewer.id());
}

void ViewerRequests::forget(const Viewer& viewer) {
  release_jogs(viewer);
  past_.forget(viewer.id());
  previews_.forget(viewer.id());
  drafts_.forget(viewer.id());
  scenarios_.forget(viewer.id());
}

}  // namespace aprsim::web
