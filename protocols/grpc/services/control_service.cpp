#include "protocols/grpc/services/control_service.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocols/grpc/calls/rpc_status.hpp"
#include "protocols/grpc/streams/state_transfer.hpp"
#include "protocols/messages/control_request.hpp"
#include "protocols/messages/control_response.hpp"
#include "protocols/messages/preview_message.hpp"
#include "protocols/messages/write_message.hpp"
#include "protocols/ports/command_failure.hpp"
#include "world/api/commands/stop_command.hpp"

namespace aprsim::grpc_server {
namespace {

constexpr std::chrono::nanoseconds kLongestWait = std::chrono::hours(1);
/// An accepted stop is confirmed after this time, whether or not a step has shown its effect.
constexpr std::chrono::milliseconds kStopDeadline{100};

/// Time for the listeners of new robots to open before a reset is confirmed.
constexpr std::chrono::seconds kListenerPatience{5};

bool may_change_robots(const api::Command& command) {
  const auto* simulation = std::get_if<api::SimulationCommand>(&command.body);
  if (simulation == nullptr) return false;
  const auto* reset = std::get_if<api::Reset>(simulation);
  return std::holds_alternative<api::LoadState>(*simulation) ||
         (reset != nullptr && !(reset->scene_name.empty() && reset->scene_text.empty()));
}

grpc::Status no_state_files() {
  return {grpc::StatusCode::FAILED_PRECONDITION,
          "state: this daemon does not export or import states"};
}

std::function<void(const grpc::Status&)> finisher(grpc::ServerUnaryReactor* reactor) {
  return [reactor](const grpc::Status& status) { reactor->Finish(status); };
}

}  // namespace

ControlService::ControlService(const TelemetryOptions& options, api::CommandSink& sink,
                               const api::SnapshotSource& source, CommandWaiter& waiter,
                               const CallGate& gate)
    : options_(options),
      sink_(sink),
      source_(source),
      waiter_(waiter),
      gate_(gate),
      transfers_(options.transfers.all_bytes) {}

std::chrono::steady_clock::time_point ControlService::deadline(
    const grpc::CallbackServerContext& context, std::chrono::nanoseconds otherwise) {
  const auto now = std::chrono::steady_clock::now();
  const auto client = context.deadline();
  if (client == std::chrono::system_clock::time_point::max()) return now + otherwise;
  const auto left = client - std::chrono::system_clock::now();
  return now +
         std::clamp<std::chrono::nanoseconds>(left, std::chrono::nanoseconds(0), kLongestWait);
}

std::optional<grpc::Status> ControlService::refusal(
    const grpc::CallbackServerContext& context) const {
  return gate_.refusal(context);
}

grpc::ServerUnaryReactor* ControlService::refuse(grpc::CallbackServerContext* context,
                                                 const Error& error) {
  return end(context, rpc_status(error));
}

grpc::ServerUnaryReactor* ControlService::end(grpc::CallbackServerContext* context,
                                              const grpc::Status& status) {
  auto* reactor = context->DefaultReactor();
  reactor->Finish(status);
  return reactor;
}

template <typename Request, typename Response>
grpc::ServerUnaryReactor* ControlService::command(grpc::CallbackServerContext* context,
                                                  const Request& request, Response& response) {
  if (const auto refused = refusal(*context)) return end(context, *refused);
  auto body = protocols::command_of(request, *source_.latest());
  if (!body) return refuse(context, body.error());
  auto* reactor = context->DefaultReactor();
  carry_out(context, finisher(reactor), *std::move(body),
            [&request, &response](const api::Snapshot& snapshot, api::Ticket ticket) {
              protocols::write_response(snapshot, ticket, request, response);
            });
  return reactor;
}

void ControlService::carry_out(grpc::CallbackServerContext* context, const Finish& finish,
                               protocols::CommandBody body, Fill fill) {
  api::Command command{options_.listener.endpoint, std::move(body)};
  const bool stop = api::is_stop(command);
  const bool changes_scene = may_change_robots(command);
  const auto ticket = sink_.submit(std::move(command));
  if (!ticket) return finish(rpc_status(ticket.error()));
  CommandWaiter::Call call{context, finish, deadline(*context), {}, {}};
  if (stop) {
    call.deadline = std::min(call.deadline, std::chrono::steady_clock::now() + kStopDeadline);
    call.confirm = [ticket = *ticket, fill](const api::Snapshot& s) { fill(s, ticket); };
  }
  call.outcome = [ticket = *ticket, fill = std::move(fill)](
                     const api::Snapshot& snapshot) -> std::optional<grpc::Status> {
    if (snapshot.applied < ticket) return std::nullopt;
    if (const Error* error = protocols::failure_of(snapshot, ticket)) return rpc_status(*error);
    fill(snapshot, ticket);
    return grpc::Status::OK;
  };
  if (changes_scene && options_.listens) await_listeners(call);
  waiter_.wait(std::move(call));
}

/// So that a client finds the ports of new robots open. They have five seconds for it.
void ControlService::await_listeners(CommandWaiter::Call& call) const {
  std::optional<grpc::Status> status;
  std::chrono::steady_clock::time_point applied;
  call.outcome = [this, outcome = std::move(call.outcome), status,
                  applied](const api::Snapshot& snapshot) mutable -> std::optional<grpc::Status> {
    const auto now = std::chrono::steady_clock::now();
    if (!status) {
      status = outcome(snapshot);
      applied = now;
    }
    const bool over = status && (!status->ok() || options_.listens(*snapshot.cell) ||
                                 now - applied >= kListenerPatience);
    return over ? status : std::nullopt;
  };
}

grpc::ServerUnaryReactor* ControlService::Pause(grpc::CallbackServerContext* context,
                                                const v1::PauseRequest* request,
                                                v1::PauseResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::Resume(grpc::CallbackServerContext* context,
                                                 const v1::ResumeRequest* request,
                                                 v1::ResumeResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::Step(grpc::CallbackServerContext* context,
                                               const v1::StepRequest* request,
                                               v1::StepResponse* response) {
  if (const auto refused = refusal(*context)) return end(context, *refused);
  const auto command = protocols::to_command(*request);
  if (!command) return refuse(context, command.error());
  const auto wanted = protocols::wanted_view(*request, *source_.latest()->cell);
  if (!wanted) return refuse(context, wanted.error());
  const std::uint64_t steps = command->steps;
  std::unique_lock lock(step_mutex_);
  const api::SnapshotPtr now = source_.latest();
  if (!now->paused && options_.listener.virtual_time &&
      options_.listener.virtual_time->is_registered("grpc")) {
    lock.unlock();
    return pass_time(context, steps, *wanted, response);
  }
  if (!now->paused) {
    return refuse(context, {ErrorCode::kFailedPrecondition, "step",
                            "the cell is running; pause it before stepping"});
  }
  const auto ticket = sink_.submit({options_.listener.endpoint, api::SimulationCommand(*command)});
  if (!ticket) return refuse(context, ticket.error());
  if (step_epoch_ != now->epoch) step_goal_ = 0;
  step_epoch_ = now->epoch;
  const std::uint64_t goal = step_goal_ = std::max(step_goal_, now->step) + steps;
  lock.unlock();

  auto* reactor = context->DefaultReactor();
  auto outcome = [=, this, wanted = *wanted, epoch = now->epoch,
                  ticket = *ticket](const api::Snapshot& s) -> std::optional<grpc::Status> {
    if (s.epoch != epoch) {
      return grpc::Status(grpc::StatusCode::ABORTED, "the cell was reset while stepping");
    }
    if (!s.world_fault.empty()) return grpc::Status(grpc::StatusCode::ABORTED, s.world_fault);
    if (s.applied < ticket || s.step < goal) return std::nullopt;
    protocols::write_receipt(s, ticket, *response->mutable_receipt());
    write_wanted(s, wanted, *response);
    return grpc::Status::OK;
  };
  auto forget = [this, context, goal] {
    const std::lock_guard goal_lock(step_mutex_);
    // A cancelled call wants no more steps; other waiting calls keep theirs.
    if (context->IsCancelled() && step_goal_ == goal) {
      (void)sink_.submit({options_.listener.endpoint, api::SimulationCommand(api::Pause{})});
    }
    // A pause drops the remaining steps: the next call must not count on them.
    step_goal_ = 0;
  };
  waiter_.wait({context, finisher(reactor), deadline(*context), std::move(outcome),
                std::move(forget), goal});
  return reactor;
}

// The reply to a command over gRPC follows its effect, so commands never wait for time to pass.
grpc::ServerUnaryReactor* ControlService::pass_time(
    grpc::CallbackServerContext* context, std::uint64_t steps,
    const std::optional<protocols::SnapshotView>& wanted, v1::StepResponse* response) {
  api::VirtualTime& time = *options_.listener.virtual_time;
  std::unique_lock lock(step_mutex_);
  if (!pacer_) {
    pacer_ = time.join({.name = "grpc"}, [] {});
    if (!pacer_) {
      return refuse(context,
                    {ErrorCode::kFailedPrecondition, "step", "another client paces as grpc"});
    }
  }
  // Time waits for its request.
  const api::SnapshotPtr now = source_.latest();
  if (step_epoch_ == now->epoch && now->step < step_goal_) {
    return refuse(context, {ErrorCode::kFailedPrecondition, "step",
                            "another call passes time; only one may at once"});
  }
  step_epoch_ = now->epoch;
  const std::uint64_t goal = step_goal_ = now->step + steps;
  time.request_until(*pacer_, now->cell->step_size * static_cast<SimTime::rep>(steps));
  lock.unlock();
  auto* reactor = context->DefaultReactor();
  auto outcome = [=, this,
                  epoch = now->epoch](const api::Snapshot& s) -> std::optional<grpc::Status> {
    if (s.epoch != epoch) {
      return grpc::Status(grpc::StatusCode::ABORTED, "the cell was reset while time passed");
    }
    if (!s.world_fault.empty()) return grpc::Status(grpc::StatusCode::ABORTED, s.world_fault);
    if (s.step < goal) return std::nullopt;
    protocols::write_receipt(s, s.applied, *response->mutable_receipt());
    write_wanted(s, wanted, *response);
    return grpc::Status::OK;
  };
  waiter_.wait({context, finisher(reactor), deadline(*context), std::move(outcome), {}, goal});
  return reactor;
}

grpc::ServerUnaryReactor* ControlService::RunUntil(grpc::CallbackServerContext* context,
                                                   const v1::RunUntilRequest* request,
                                                   v1::RunUntilResponse* response) {
  if (const auto refused = refusal(*context)) return end(context, *refused);
  const auto run = protocols::to_command(*request);
  if (!run) return refuse(context, run.error());
  const auto wanted = protocols::wanted_view(*request, *source_.latest()->cell);
  if (!wanted) return refuse(context, wanted.error());
  const auto ticket = sink_.submit({options_.listener.endpoint, api::SimulationCommand(*run)});
  if (!ticket) return refuse(context, ticket.error());
  auto* reactor = context->DefaultReactor();
  auto outcome = [this, ticket = *ticket, wanted = *wanted,
                  response](const api::Snapshot& s) -> std::optional<grpc::Status> {
    if (s.applied < ticket) return std::nullopt;
    if (const Error* error = protocols::failure_of(s, ticket)) return rpc_status(*error);
    if (!s.runs) return std::nullopt;
    const auto ended = std::ranges::find(*s.runs, ticket, &api::RunEnd::run);
    if (ended == s.runs->end()) return std::nullopt;
    return finish_run(*ended, s, wanted, *response);
  };
  auto give_up = [this, ticket = *ticket] {
    (void)sink_.submit({options_.listener.endpoint, api::SimulationCommand(api::EndRun{ticket})});
  };
  waiter_.wait({context, finisher(reactor), deadline(*context, kLongestWait), std::move(outcome),
                std::move(give_up)});
  return reactor;
}

grpc::Status ControlService::finish_run(const api::RunEnd& ended, const api::Snapshot& snapshot,
                                        const std::optional<protocols::SnapshotView>& wanted,
                                        v1::RunUntilResponse& response) const {
  if (ended.why == api::RunEnd::Why::kInterrupted) {
    return {grpc::StatusCode::ABORTED, "the run has ended before: " + ended.text};
  }
  protocols::write_response(snapshot, ended, options_.events, response);
  write_wanted(snapshot, wanted, response);
  return grpc::Status::OK;
}

template <typename Response>
void ControlService::write_wanted(const api::Snapshot& snapshot,
                                  const std::optional<protocols::SnapshotView>& wanted,
                                  Response& response) const {
  if (!wanted) return;
  wanted->write(snapshot, options_.instance_id, *response.mutable_snapshot());
}

grpc::ServerUnaryReactor* ControlService::SetSpeed(grpc::CallbackServerContext* context,
                                                   const v1::SetSpeedRequest* request,
                                                   v1::SetSpeedResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::Reset(grpc::CallbackServerContext* context,
                                                const v1::ResetRequest* request,
                                                v1::ResetResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::SaveState(grpc::CallbackServerContext* context,
                                                    const v1::SaveStateRequest* request,
                                                    v1::SaveStateResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::LoadState(grpc::CallbackServerContext* context,
                                                    const v1::LoadStateRequest* request,
                                                    v1::LoadStateResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::DeleteState(grpc::CallbackServerContext* context,
                                                      const v1::DeleteStateRequest* request,
                                                      v1::DeleteStateResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerWriteReactor<v1::ExportStateResponse>* ControlService::ExportState(
    grpc::CallbackServerContext* context, const v1::ExportStateRequest* request) {
  if (const auto refused = refusal(*context)) return new FileSender(*refused);
  if (options_.state_files == nullptr) return new FileSender(no_state_files());
  const auto saved = source_.latest()->saved_states;
  if (saved) {
    for (const api::SavedState& state : saved->states) {
      if (state.name != request->name() || !state.state) continue;
      auto bytes = options_.state_files->write(state.name, state.state);
      if (!bytes) return new FileSender(rpc_status(bytes.error()));
      return new FileSender(*std::move(bytes), transfers_);
    }
  }
  return new FileSender(
      rpc_status({ErrorCode::kNotFound, "name", "no state is saved as '" + request->name() + "'"}));
}

grpc::ServerReadReactor<v1::ImportStateRequest>* ControlService::ImportState(
    grpc::CallbackServerContext* context, v1::ImportStateResponse* response) {
  if (const auto refused = refusal(*context)) return new FileReceiver(*refused);
  if (options_.state_files == nullptr) return new FileReceiver(no_state_files());
  return new FileReceiver(
      options_.transfers, transfers_,
      [this, context, response](FileReceiver& receiver, std::string name, std::string bytes) {
        // A cancelled client has not sent its whole file.
        if (context->IsCancelled()) return receiver.end(grpc::Status::CANCELLED);
        auto file = options_.state_files->read(std::move(bytes));
        if (!file) return receiver.end(rpc_status(file.error()));
        response->set_name(name.empty() ? file->name : name);
        api::SaveState save{response->name(), std::move(file->state)};
        carry_out(
            context, [&receiver](const grpc::Status& status) { receiver.end(status); },
            api::SimulationCommand(std::move(save)),
            [response](const auto& s, auto t) {
              protocols::write_receipt(s, t, *response->mutable_receipt());
            });
      });
}

grpc::ServerUnaryReactor* ControlService::ListStates(grpc::CallbackServerContext* context,
                                                     const v1::ListStatesRequest* /*request*/,
                                                     v1::ListStatesResponse* response) {
  if (const auto refused = refusal(*context)) return end(context, *refused);
  protocols::write_response(*source_.latest(), *response);
  auto* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

grpc::ServerUnaryReactor* ControlService::SpawnBody(grpc::CallbackServerContext* context,
                                                    const v1::SpawnBodyRequest* request,
                                                    v1::SpawnBodyResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::MoveBody(grpc::CallbackServerContext* context,
                                                   const v1::MoveBodyRequest* request,
                                                   v1::MoveBodyResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::RemoveBody(grpc::CallbackServerContext* context,
                                                     const v1::RemoveBodyRequest* request,
                                                     v1::RemoveBodyResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::SetSceneValue(grpc::CallbackServerContext* context,
                                                        const v1::SetSceneValueRequest* request,
                                                        v1::SetSceneValueResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::SetConveyor(grpc::CallbackServerContext* context,
                                                      const v1::SetConveyorRequest* request,
                                                      v1::SetConveyorResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::SetSignals(grpc::CallbackServerContext* context,
                                                     const v1::SetSignalsRequest* request,
                                                     v1::SetSignalsResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::SetPlanning(grpc::CallbackServerContext* context,
                                                      const v1::SetPlanningRequest* request,
                                                      v1::SetPlanningResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::PreviewMove(grpc::CallbackServerContext* context,
                                                      const v1::PreviewMoveRequest* request,
                                                      v1::PreviewMoveResponse* response) {
  if (const auto refused = refusal(*context)) return end(context, *refused);
  if (options_.previews == nullptr) {
    return refuse(context, {ErrorCode::kFailedPrecondition, "preview",
                            "this daemon plans no moves: it replays a run"});
  }
  auto move = protocols::to_preview(*request, *source_.latest()->cell);
  if (!move) return refuse(context, move.error());
  auto* reactor = context->DefaultReactor();
  options_.previews->ask(*std::move(move),
                         [reactor, response](const Result<api::MovePreview>& preview) {
                           if (!preview) return reactor->Finish(rpc_status(preview.error()));
                           protocols::write_message(*preview, *response);
                           reactor->Finish(grpc::Status::OK);
                         });
  return reactor;
}

grpc::ServerUnaryReactor* ControlService::SetIntruder(grpc::CallbackServerContext* context,
                                                      const v1::SetIntruderRequest* request,
                                                      v1::SetIntruderResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::InjectFault(grpc::CallbackServerContext* context,
                                                      const v1::InjectFaultRequest* request,
                                                      v1::InjectFaultResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::EndFault(grpc::CallbackServerContext* context,
                                                   const v1::EndFaultRequest* request,
                                                   v1::EndFaultResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::ReportEvent(grpc::CallbackServerContext* context,
                                                      const v1::ReportEventRequest* request,
                                                      v1::ReportEventResponse* response) {
  return command(context, *request, *response);
}

grpc::ServerUnaryReactor* ControlService::ListFaultKinds(
    grpc::CallbackServerContext* context, const v1::ListFaultKindsRequest* /*request*/,
    v1::ListFaultKindsResponse* response) {
  if (const auto refused = refusal(*context)) return end(context, *refused);
  protocols::write_fault_kinds(*response);
  auto* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

}  // namespace aprsim::grpc_server
