#include "protocols/web/viewer/viewer_hub.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "protocols/access/call_roles.hpp"
#include "protocols/messages/history_message.hpp"
#include "protocols/messages/write_message.hpp"
#include "protocols/ports/command_failure.hpp"
#include "protocols/web/http/request_text.hpp"
#include "protocols/web/jog/manual_mode.hpp"
#include "protocols/web/topics/register_view.hpp"
#include "protocols/web/viewer/viewer_command.hpp"
#include "protocols/web/viewer/viewer_message.hpp"

namespace aprsim::web {
namespace {

// Shows a viewer of a paused cell that the daemon is there.
constexpr auto kLongestSilence = std::chrono::milliseconds(500);
constexpr auto kRegisterPeriod = std::chrono::milliseconds(100);
constexpr auto kStatusPeriod = std::chrono::seconds(1);
constexpr auto kFaultPeriod = std::chrono::milliseconds(500);
constexpr auto kProgramPeriod = std::chrono::milliseconds(250);
constexpr auto kHistoryPeriod = std::chrono::milliseconds(250);
constexpr auto kBookmarkPeriod = std::chrono::seconds(1);
constexpr std::size_t kEventBytesPerTick = std::size_t{96} << 10;

WebMessage pack(const v1::ViewerUpdate& update) {
  return std::make_shared<const std::string>(update.SerializeAsString());
}

std::string random_id() {
  std::random_device device;
  return fmt::format("{:08x}{:08x}", device(), device());
}

/// Where none can be started.
std::shared_ptr<const ProgramStatus> no_programs() {
  static const auto none = std::make_shared<const ProgramStatus>(
      ProgramStatus{.refusal = "This daemon starts no programs (web.programs)."});
  return none;
}

tl::unexpected<Error> no_past() {
  return fail(ErrorCode::kFailedPrecondition, "past",
              "this daemon keeps no past (history.minutes is 0)");
}

/// Answered by its outcome in the cell, or by what it asks for.
bool answered_later(const v1::ViewerRequest& request) {
  return request.jog().step() != 0 || request.has_past() || request.has_resume_from();
}

/// The descriptions have them, in the same order.
void drop_names(v1::Snapshot& snapshot) {
  for (auto& body : *snapshot.mutable_bodies()) {
    body.clear_name();
    body.clear_type();
  }
}

/// The name of what is asked for; empty = nothing that is known here.
std::string kind_of(const v1::ViewerRequest& request) {
  const auto* field = v1::ViewerRequest::descriptor()->FindFieldByNumber(request.body_case());
  return field == nullptr ? "" : field->name();
}

bool concerns_faults(const v1::ViewerRequest& request) {
  return request.has_inject_fault() || request.has_end_fault() || request.has_report_event();
}

}  // namespace

ViewerHub::ViewerHub(const WebServerOptions& options, api::CommandSink& sink,
                     const api::SnapshotSource& source, WebCounts& counts)
    : options_(options),
      sink_(sink),
      source_(source),
      counts_(counts),
      instance_id_(random_id()),
      device_(options.scaling, options.endpoint, sink, source),
      faults_(source.latest()),
      past_(options.history) {
  const api::SnapshotPtr snapshot = source.latest();
  if (snapshot->cell->light_curtain) beams_ = snapshot->cell->light_curtain->beams;
  const auto robots = static_cast<int>(snapshot->cell->robots.size());
  for (int robot = 0; robot < robots; ++robot) {
    joggers_.emplace_back(robot, options.endpoint, sink, options.jog_timeout);
  }
}

void ViewerHub::add(std::shared_ptr<WebSocket> socket, std::string peer, protocols::Caller caller) {
  spdlog::info("web: viewer {} connected", peer);
  const auto viewer = std::make_shared<Viewer>(
      ++next_id_, std::move(socket), std::move(peer),
      Viewer::Events{[this](Viewer& from, const auto& request) { answer(from, request); },
                     [this](Viewer& ended) { remove(ended); }});
  viewers_[viewer->id()] = viewer;
  viewer->trace = protocols::ConnectionTrace(options_.trace, source_, protocols::WireKind::kWeb,
                                             "web", viewer->peer());
  viewer->caller = std::move(caller);
  viewer->set_rate(options_.max_rate_hz);
  viewer->start();
  greet(*viewer);
}

void ViewerHub::greet(Viewer& viewer) {
  v1::ViewerUpdate update;
  auto& welcome = *update.mutable_welcome();
  welcome.set_instance_id(instance_id_);
  welcome.set_version(options_.version);
  welcome.set_max_rate_hz(options_.max_rate_hz);
  welcome.set_jog_timeout_s(std::chrono::duration<double>(options_.jog_timeout).count());
  welcome.set_manual_speed_m_s(kManualSpeed_m_s);
  viewer.send(pack(update));
  update_permission(viewer, true);
}

void ViewerHub::update_permission(Viewer& viewer, bool first) {
  const protocols::Role role = role_of(viewer);
  if (role == viewer.role && !first) return;
  viewer.role = role;
  v1::ViewerUpdate update;
  *update.mutable_permission() = permission(viewer);
  viewer.send(pack(update));
  if (role < protocols::Role::kView || viewer.shown) return;
  viewer.shown = true;
  protocols::write_fault_kinds(*update.mutable_fault_kinds());
  viewer.send(pack(update));
  write_message(options_.scaling, beams_, *update.mutable_register_map());
  viewer.send(pack(update));
}

protocols::Role ViewerHub::role_of(const Viewer& viewer) const {
  const protocols::Role role = options_.access->still(viewer.caller);
  return commands() ? role : std::min(role, protocols::Role::kView);
}

v1::Permission ViewerHub::permission(const Viewer& viewer) const {
  v1::Permission permission;
  permission.set_role(std::string(protocols::to_text(viewer.role)));
  permission.set_name(viewer.caller.name);
  permission.set_control(viewer.role >= protocols::Role::kOperate);
  permission.set_token_helps(options_.access->has_credentials() &&
                             viewer.role <
                                 (commands() ? protocols::Role::kAdmin : protocols::Role::kView));
  if (viewer.role < protocols::Role::kView) {
    permission.set_reason("Looking needs an access token.");
  } else if (!options_.read_only.empty()) {
    permission.set_reason(options_.read_only);
  } else if (!options_.control) {
    permission.set_reason("This view is read-only (web.control is false).");
  } else if (permission.control()) {
    return permission;
  } else if (permission.token_helps()) {
    permission.set_reason("Control needs the access token.");
  } else {
    permission.set_reason(
        "From other machines this view is read-only: the daemon knows no tokens (access.file).");
  }
  return permission;
}

Result<void> ViewerHub::check_role(const Viewer& viewer, const std::string& request) {
  const std::string call = "aprsim.v1.ViewerRequest/" + request;
  const protocols::Role needed = protocols::role_needed(call);
  if (!commands() && needed > protocols::Role::kView) {
    return fail(ErrorCode::kFailedPrecondition, "permission", permission(viewer).reason());
  }
  protocols::Caller caller = viewer.caller;
  caller.role = role_of(viewer);
  const auto refusal = options_.access->refusal(caller, request, needed);
  if (!refusal) return {};
  log_.warn(viewer.peer() + " is refused: " + refusal->message);
  return fail(ErrorCode::kFailedPrecondition, "permission", refusal->message);
}

void ViewerHub::answer(Viewer& viewer, const v1::ViewerRequest& request) {
  const auto asked = Clock::now();
  ++counts_.requests;
  const auto done = execute(viewer, request);
  // What concerns faults is answered once the cell has taken it.
  if (done && (answered_later(request) || concerns_faults(request))) return;
  counts_.answered(Clock::now() - asked, done.has_value());
  send_outcome(viewer, request.id(), done);
}

void ViewerHub::answer_awaited(const api::Snapshot& snapshot) {
  std::vector<Awaited> due;
  std::erase_if(awaited_, [&](const Awaited& awaited) {
    if (awaited.ticket > snapshot.applied) return false;
    due.push_back(awaited);
    return true;
  });
  for (const Awaited& awaited : due) {
    const auto viewer = viewers_.find(awaited.viewer);
    if (viewer == viewers_.end()) continue;
    // It may end, and leave the map, while it is written to.
    const auto kept = viewer->second;
    const Error* error = protocols::failure_of(snapshot, awaited.ticket);
    counts_.answered(Clock::now() - awaited.asked, error == nullptr);
    send_outcome(*kept, awaited.request, error ? tl::unexpected(*error) : Result<void>());
  }
}

void ViewerHub::send_outcome(Viewer& viewer, std::uint32_t id, const Result<void>& done) {
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

Result<void> ViewerHub::execute(Viewer& viewer, const v1::ViewerRequest& request) {
  if (request.has_authenticate()) return authenticate(viewer, request.authenticate().token());
  const auto allowed = check_role(viewer, kind_of(request));
  if (request.has_watch()) {
    if (allowed) set_watch(viewer, request.watch());
    return allowed;
  }
  if (request.has_past()) {
    if (!allowed) return allowed;
    if (options_.history == nullptr) return no_past();
    past_.ask({viewer.id(), request.id(), protocols::to_moment(request.past())});
    return {};
  }
  const auto done = allowed ? command(viewer, request) : allowed;
  note(viewer, request, done);
  return done;
}

Result<void> ViewerHub::command(Viewer& viewer, const v1::ViewerRequest& request) {
  if (request.has_write_register()) return write_register(request.write_register());
  if (request.has_start_program() || request.has_stop_program()) return command_programs(request);
  if (const auto done = command_history(viewer, request)) return *done;
  const api::SnapshotPtr snapshot = source_.latest();
  if (request.has_jog()) {
    if (request.jog().robot() >= joggers_.size()) {
      return fail(ErrorCode::kNotFound, "robot",
                  fmt::format("{} is not below {}", request.jog().robot(), joggers_.size()));
    }
    Jogger& jogger = joggers_[request.jog().robot()];
    if (request.jog().step() != 0) {
      return jogger.step(viewer.id(), request.id(), request.jog(), *snapshot);
    }
    return jogger.renew(viewer.id(), request.jog(), *snapshot, Clock::now());
  }
  const auto commands = commands_of(request, *snapshot);
  if (!commands) return fail(ErrorCode::kUnimplemented, "body", "no request that is known here");
  if (!*commands) return tl::unexpected(commands->error());
  // All are tried: of a stop of the whole cell, whatever can be stopped is.
  Result<void> done;
  for (const auto& body : **commands) {
    const auto ticket = sink_.submit({options_.endpoint, body});
    if (!ticket && done) done = tl::unexpected(ticket.error());
    if (ticket && concerns_faults(request)) {
      awaited_.push_back({viewer.id(), request.id(), *ticket, Clock::now()});
    }
  }
  return done;
}

std::optional<Result<void>> ViewerHub::command_history(const Viewer& viewer,
                                                       const v1::ViewerRequest& request) {
  const bool concerned =
      request.has_resume_from() || request.has_add_bookmark() || request.has_remove_bookmark();
  if (!concerned) return std::nullopt;
  if (options_.history == nullptr) return no_past();
  if (request.has_resume_from()) {
    const api::Moment moment = protocols::to_moment(request.resume_from().moment());
    past_.ask({viewer.id(), request.id(), moment, true});
    return Result<void>();
  }
  if (request.has_remove_bookmark()) {
    return options_.history->remove_bookmark(request.remove_bookmark().id());
  }
  const v1::AddBookmarkRequest& add = request.add_bookmark();
  const auto added = options_.history->add_bookmark(protocols::to_moment(add.moment()), add.text());
  return added ? Result<void>() : tl::unexpected(added.error());
}

void ViewerHub::answer_past() {
  for (const PastDesk::Answer& answer : past_.take()) {
    const PastDesk::Question& question = answer.question;
    const auto viewer = viewers_.find(question.viewer);
    if (viewer == viewers_.end()) continue;
    // It may end, and leave the map, while it is written to.
    const auto kept = viewer->second;
    if (!answer.past) {
      send_outcome(*kept, question.request, tl::unexpected(answer.past.error()));
    } else if (question.resume) {
      const auto ticket = sink_.submit(
          {options_.endpoint,
           api::SimulationCommand(protocols::resumption(question.moment, *answer.past))});
      if (ticket) {
        awaited_.push_back({question.viewer, question.request, *ticket, Clock::now()});
      } else {
        send_outcome(*kept, question.request, tl::unexpected(ticket.error()));
      }
    } else {
      update_.Clear();
      update_.mutable_past()->set_id(question.request);
      auto& snapshot = *update_.mutable_past()->mutable_snapshot();
      protocols::write_message(*answer.past->snapshot, instance_id_, snapshot);
      drop_names(snapshot);
      const api::CellDescription& cell = *answer.past->snapshot->cell;
      if (!same_scene(cell, *source_.latest()->cell)) {
        protocols::write_message(cell, *update_.mutable_past()->mutable_cell());
        past_looks_.follow(cell, options_.visual);
        *update_.mutable_past()->mutable_looks() = past_looks_.message();
      }
      kept->send(pack(update_));
    }
  }
}

Result<void> ViewerHub::command_programs(const v1::ViewerRequest& request) {
  if (options_.programs == nullptr) {
    return fail(ErrorCode::kFailedPrecondition, "programs", no_programs()->refusal);
  }
  if (request.has_stop_program()) return options_.programs->stop();
  const v1::StartProgram& start = request.start_program();
  return options_.programs->start(start.name(),
                                  start.has_seed() ? std::optional(start.seed()) : std::nullopt);
}

Result<void> ViewerHub::write_register(const v1::WriteRegister& write) {
  const auto checked = to_register_write(write);
  if (!checked) return tl::unexpected(checked.error());
  device_.refresh();
  const auto ticket = device_.write(checked->request());
  if (ticket) return {};
  switch (ticket.error()) {
    case modbus::ExceptionCode::kServerDeviceBusy:
      return fail(ErrorCode::kUnavailable, "value",
                  "not written: too many commands wait for the simulation; try again");
    case modbus::ExceptionCode::kServerDeviceFailure:
      return fail(ErrorCode::kFailedPrecondition, "value",
                  "not written: this cell has no conveyor");
    default:
      return fail(ErrorCode::kInvalidArgument, "value",
                  fmt::format("{}: not written (Modbus exception {})", write.value(),
                              static_cast<int>(ticket.error())));
  }
}

void ViewerHub::note(Viewer& viewer, const v1::ViewerRequest& request, const Result<void>& done) {
  if (options_.trace != nullptr) {
    viewer.trace.received(request.SerializeAsString(),
                          done ? std::string_view() : std::string_view(done.error().message));
  }
  if (!done) refused(kind_of(request) + " of " + viewer.peer() + ": " + done.error().message);
  protocols::WireEvent event{.source = "page",
                             .peer = viewer.peer(),
                             .from_client = true,
                             .time = std::chrono::system_clock::now(),
                             .id = request.id(),
                             .state = done ? "" : done.error().message};
  if (request.has_jog()) {
    // It is renewed all the time: what differs is what counts.
    std::string jog = request.jog().SerializeAsString() + event.state;
    if (viewer.noted == jog) return;
    viewer.noted = std::move(jog);
  }
  event.type = title_of(request, *source_.latest()->cell);
  event.data = json_of(request);
  if (options_.audit != nullptr) {
    options_.audit->write({.wire = "web",
                           .peer = viewer.peer(),
                           .who = viewer.caller.text(),
                           .command = kind_of(request),
                           .request = event.data,
                           .outcome = done ? "ok" : done.error().message,
                           .time = event.time});
  }
  const bool of_the_belt = request.has_conveyor() || request.has_write_register();
  if (options_.modbus_tap && of_the_belt) options_.modbus_tap->note(event);
  if (options_.crcl_tap) options_.crcl_tap->note(std::move(event));
}

void ViewerHub::refused(const std::string& what) {
  if (options_.refusals != nullptr) options_.refusals->refused("web", what);
}

Result<void> ViewerHub::authenticate(Viewer& viewer, const std::string& token) {
  using Problem = protocols::Caller::Problem;
  if (!options_.access->has_credentials()) return {};
  protocols::Caller caller =
      options_.access->identify(protocols::host_of(viewer.peer()),
                                {.token = token, .certificate = viewer.caller.certificate});
  switch (caller.problem) {
    case Problem::kTooManyAttempts:
      return fail(ErrorCode::kUnavailable, "token", "too many attempts; wait a while");
    case Problem::kWrongToken:
      log_.warn("viewer " + viewer.peer() + " gave a wrong token");
      refused("token of " + viewer.peer() + ": it is not the right one");
      return fail(ErrorCode::kInvalidArgument, "token", "it is not the right one");
    case Problem::kExpired:
      log_.warn("viewer " + viewer.peer() + " gave an expired token, " + caller.name);
      refused("token of " + viewer.peer() + ": it has expired");
      return fail(ErrorCode::kInvalidArgument, "token", "it has expired");
    case Problem::kNone:
      break;
  }
  viewer.caller = std::move(caller);
  update_permission(viewer, true);
  return {};
}

void ViewerHub::set_watch(Viewer& viewer, const v1::Watch& watch) {
  viewer.watch = watch;
  const bool limited = std::isfinite(watch.rate_hz()) && watch.rate_hz() > 0;
  viewer.set_rate(limited ? std::clamp(watch.rate_hz(), 0.1, options_.max_rate_hz)
                          : options_.max_rate_hz);
  update_taps();
}

void ViewerHub::update_taps() {
  bool crcl = false, modbus = false;
  for (const auto& [id, viewer] : viewers_) {
    crcl = crcl || (viewer->watch.crcl() && viewer->watch.polls());
    modbus = modbus || (viewer->watch.modbus() && viewer->watch.polls());
  }
  if (options_.crcl_tap) options_.crcl_tap->want_polls(crcl);
  if (options_.modbus_tap) options_.modbus_tap->want_polls(modbus);
}

void ViewerHub::remove(Viewer& viewer) {
  for (Jogger& jogger : joggers_) jogger.release(viewer.id());
  past_.forget(viewer.id());
  viewers_.erase(viewer.id());
  update_taps();
}

void ViewerHub::close() {
  for_each([this](Viewer& viewer) {
    for (Jogger& jogger : joggers_) jogger.release(viewer.id());
    viewer.close("the daemon stops");
  });
}

void ViewerHub::drop() {
  for_each([](Viewer& viewer) { viewer.drop(); });
}

// The joggers look at what the viewers are sent, and before them: who has seen another client's
// command take a robot over finds its jog ended.
void ViewerHub::tick(Clock::time_point now) {
  const api::SnapshotPtr snapshot = source_.latest();
  for (Jogger& jogger : joggers_) {
    jogger.tick(*snapshot, now);
    for (const auto& step : jogger.take_ended()) {
      const auto viewer = viewers_.find(step.viewer);
      if (viewer == viewers_.end()) continue;
      // It may end, and leave the map, while it is written to.
      const auto kept = viewer->second;
      send_outcome(*kept, step.id, step.outcome);
    }
  }
  faults_.look(snapshot, source_.problem(), std::chrono::system_clock::now(),
               [this](int robot, api::Ticket ticket) {
                 return joggers_[static_cast<std::size_t>(robot)].sent(ticket);
               });
  answer_awaited(*snapshot);
  answer_past();
  if (viewers_.empty()) return;
  send_snapshots(snapshot, now);
  if (now - registers_at_ >= kRegisterPeriod) {
    registers_at_ = now;
    send_registers();
  }
  if (now - status_at_ >= kStatusPeriod) {
    status_at_ = now;
    // Tokens expire, and are removed.
    for_each([this](Viewer& viewer) { update_permission(viewer); });
    send_status();
  }
  send_faults(now);
  send_programs(now);
  send_history(now);
  send_events(options_.crcl_tap, "crcl", &v1::Watch::crcl, &Viewer::Next::crcl);
  send_events(options_.modbus_tap, "modbus", &v1::Watch::modbus, &Viewer::Next::modbus);
}

void ViewerHub::send_snapshots(const api::SnapshotPtr& snapshot, Clock::time_point now) {
  if (snapshot != sent_ || now - sent_at_ >= kLongestSilence) {
    sent_ = snapshot;
    sent_at_ = now;
  } else if (std::none_of(viewers_.begin(), viewers_.end(), [&](const auto& entry) {
               return entry.second->cell != snapshot->cell;
             })) {
    return;
  }
  WebMessage cell, state;
  for_each_that_looks([&](Viewer& viewer) {
    if (!viewer.due(now)) return;
    if (viewer.cell != snapshot->cell) send_cell(viewer, snapshot->cell, cell);
    if (!state) {
      update_.Clear();
      protocols::write_message(*snapshot, instance_id_, *update_.mutable_snapshot());
      drop_names(*update_.mutable_snapshot());
      state = pack(update_);
    }
    if (!viewer.offer_snapshot(state)) ++counts_.skipped;
  });
}

void ViewerHub::send_cell(Viewer& viewer, const std::shared_ptr<const api::CellDescription>& cell,
                          WebMessage& message) {
  if (!message) {
    if (looks_.follow(*cell, options_.visual)) {
      update_.Clear();
      *update_.mutable_looks() = looks_.message();
      looks_message_ = pack(update_);
    }
    update_.Clear();
    protocols::write_message(*cell, *update_.mutable_cell());
    message = pack(update_);
  }
  if (viewer.looks != looks_message_) viewer.send(looks_message_);
  viewer.looks = looks_message_;
  viewer.cell = cell;
  viewer.send(message);
}

void ViewerHub::send_registers() {
  WebMessage message;
  for_each_that_looks([&](Viewer& viewer) {
    if (!viewer.watch.registers()) return;
    if (!message) {
      device_.refresh();
      update_.Clear();
      write_message(device_.image(), beams_, *update_.mutable_registers());
      message = pack(update_);
    }
    viewer.offer_registers(message);
  });
}

void ViewerHub::send_status() {
  if (!options_.listeners) return;
  const auto listeners = options_.listeners();
  const auto saved = source_.latest()->saved_states;
  for_each_that_looks([&](Viewer& viewer) {
    update_.Clear();
    auto& status = *update_.mutable_status();
    status.set_skipped_snapshots(viewer.skipped());
    for (const ListenerCount& listener : listeners) {
      auto& out = *status.add_listeners();
      out.set_name(listener.name);
      out.set_port(listener.port);
      out.set_clients(static_cast<std::uint32_t>(listener.clients));
    }
    if (saved) {
      for (const api::SavedState& state : saved->states) status.add_saved_states(state.name);
    }
    (void)viewer.send_if_quick(pack(update_));
  });
}

void ViewerHub::send_faults(Clock::time_point now) {
  const bool due = now - faults_at_ >= kFaultPeriod;
  if (due) faults_at_ = now;
  WebMessage message;
  for_each_that_looks([&](Viewer& viewer) {
    const bool first = viewer.next_events.faults == ~std::uint64_t{0};
    if (viewer.next_events.faults == faults_.revision() || !(due || first)) return;
    if (!message) {
      update_.Clear();
      write_message(faults_, *update_.mutable_faults());
      message = pack(update_);
    }
    if (viewer.send_if_quick(message)) viewer.next_events.faults = faults_.revision();
  });
}

void ViewerHub::send_programs(Clock::time_point now) {
  if (now - programs_at_ < kProgramPeriod) return;
  programs_at_ = now;
  const auto status = options_.programs ? options_.programs->status() : no_programs();
  WebMessage message;
  for_each_that_looks([&](Viewer& viewer) {
    if (viewer.programs == status) return;
    if (!message) {
      update_.Clear();
      write_message(*status, *update_.mutable_programs());
      message = pack(update_);
    }
    if (viewer.send_if_quick(message)) viewer.programs = status;
  });
}

void ViewerHub::send_history(Clock::time_point now) {
  if (options_.history == nullptr || now - history_at_ < kHistoryPeriod) return;
  history_at_ = now;
  update_.Clear();
  protocols::write_message(options_.history->spans(), *update_.mutable_history());
  const WebMessage spans = pack(update_);
  const std::uint64_t revision = options_.history->bookmark_revision();
  const bool due = now - bookmarks_at_ >= kBookmarkPeriod;
  if (due) bookmarks_at_ = now;
  WebMessage bookmarks;
  for_each([&](Viewer& viewer) {
    (void)viewer.send_if_quick(spans);
    if (!due || viewer.next_events.bookmarks == revision) return;
    if (!bookmarks) {
      update_.Clear();
      protocols::write_message(options_.history->bookmarks(), *update_.mutable_bookmarks());
      bookmarks = pack(update_);
    }
    if (viewer.send_if_quick(bookmarks)) viewer.next_events.bookmarks = revision;
  });
}

// A viewer gets the next of them when it has taken those before: a slow one, or one that catches up
// with what was kept, has no more than one message waiting.
void ViewerHub::send_events(protocols::WireTap* tap, const char* wire,
                            bool (v1::Watch::*wants)() const, std::uint64_t Viewer::Next::*next) {
  if (!tap) return;
  for_each_that_looks([&](Viewer& viewer) {
    if (!(viewer.watch.*wants)() || !viewer.idle()) return;
    std::uint64_t& from = viewer.next_events.*next;
    events_.clear();
    from = tap->read(from, viewer.watch.polls(), kEventBytesPerTick, events_);
    if (events_.empty()) return;
    update_.Clear();
    auto& out = *update_.mutable_wire_events();
    out.set_wire(wire);
    out.set_dropped(tap->given_up());
    for (const auto& event : events_) write_message(*event, *out.add_events());
    viewer.send(pack(update_));
  });
}

// A viewer may end, and leave the map, while it is visited.
template <typename Visit>
void ViewerHub::for_each(const Visit& visit) {
  std::vector<std::shared_ptr<Viewer>> all;
  all.reserve(viewers_.size());
  for (const auto& [id, viewer] : viewers_) all.push_back(viewer);
  for (const auto& viewer : all) visit(*viewer);
}

template <typename Visit>
void ViewerHub::for_each_that_looks(const Visit& visit) {
  for_each([&visit](Viewer& viewer) {
    if (viewer.role >= protocols::Role::kView) visit(viewer);
  });
}

}  // namespace aprsim::web
