#include <array>
#include <atomic>
#include <limits>
#include <optional>
#include <thread>
#include <vector>

#include "tests/unit/protocols/grpc/telemetry_fixture.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;
using Control = TelemetryFixture;

template <typename T>
std::optional<T> simulation_command(const api::Command& command) {
  const auto* simulation = std::get_if<api::SimulationCommand>(&command.body);
  const T* wanted = simulation == nullptr ? nullptr : std::get_if<T>(simulation);
  return wanted == nullptr ? std::nullopt : std::optional<T>(*wanted);
}

TEST_F(Control, PauseAndResumeTakeEffectBeforeTheAnswer) {
  start({.listener = {.endpoint = 42}});
  {
    grpc::ClientContext context;
    v1::PauseResponse response;
    ASSERT_TRUE(control_->Pause(&context, {}, &response).ok());
    EXPECT_EQ(response.receipt().ticket(), 1U);
    EXPECT_EQ(response.receipt().step(), 100U);
    EXPECT_TRUE(cell_->latest()->paused);
  }
  grpc::ClientContext context;
  v1::ResumeResponse response;
  ASSERT_TRUE(control_->Resume(&context, {}, &response).ok());
  EXPECT_FALSE(cell_->latest()->paused);
  const auto commands = cell_->commands();
  ASSERT_EQ(commands.size(), 2U);
  EXPECT_EQ(commands[0].endpoint, 42U);
  EXPECT_TRUE(simulation_command<api::Pause>(commands[0]).has_value());
  EXPECT_TRUE(simulation_command<api::Resume>(commands[1]).has_value());
}

/// The simulation takes no step at all, as on a machine that starves it.
TEST_F(Control, StopsAreAnsweredWithoutAStep) {
  start();
  cell_->hold();
  grpc::ClientContext first, second, third;
  v1::PauseResponse paused;
  EXPECT_TRUE(control_->Pause(&first, {}, &paused).ok());
  EXPECT_EQ(paused.receipt().ticket(), 1U);
  v1::SetConveyorRequest stop;
  stop.set_emergency_stop(true);
  v1::SetConveyorResponse stopped;
  EXPECT_TRUE(control_->SetConveyor(&second, stop, &stopped).ok());
  // All else waits for its effect.
  set_deadline(third, 300ms);
  v1::ResumeResponse resumed;
  EXPECT_EQ(control_->Resume(&third, {}, &resumed).error_code(),
            grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(cell_->commands().size(), 3U);
}

TEST_F(Control, SpeedArrivesAsFactorOrMaximum) {
  start();
  v1::SetSpeedRequest request;
  request.set_factor(2.5);
  v1::SetSpeedResponse response;
  grpc::ClientContext first;
  ASSERT_TRUE(control_->SetSpeed(&first, request, &response).ok());
  EXPECT_EQ(cell_->latest()->speed_target, 2.5);
  request.set_maximum(true);
  grpc::ClientContext second;
  ASSERT_TRUE(control_->SetSpeed(&second, request, &response).ok());
  EXPECT_FALSE(cell_->latest()->speed_target.has_value());
}

TEST_F(Control, BadSpeedsAreInvalidAndSubmitNothing) {
  start();
  v1::SetSpeedRequest none, zero, negative, infinite, not_maximum, slow, fast;
  slow.set_factor(1e-13);
  fast.set_factor(1e14);
  zero.set_factor(0);
  negative.set_factor(-1);
  infinite.set_factor(std::numeric_limits<double>::infinity());
  not_maximum.set_maximum(false);
  for (const auto& request : {none, zero, negative, infinite, not_maximum, slow, fast}) {
    grpc::ClientContext context;
    v1::SetSpeedResponse response;
    EXPECT_EQ(control_->SetSpeed(&context, request, &response).error_code(),
              grpc::StatusCode::INVALID_ARGUMENT);
  }
  EXPECT_TRUE(cell_->commands().empty());
}

TEST_F(Control, ResetGivesTheNewEpochAndPassesTheSeed) {
  start();
  v1::ResetRequest request;
  request.set_seed(99);
  v1::ResetResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(control_->Reset(&context, request, &response).ok());
  EXPECT_EQ(response.receipt().epoch(), 1U);
  EXPECT_EQ(response.receipt().step(), 0U);
  const auto reset = simulation_command<api::Reset>(cell_->commands().at(0));
  ASSERT_TRUE(reset.has_value());
  EXPECT_EQ(reset->seed, 99U);
}

TEST_F(Control, OnlyASavedStateCanBeLoaded) {
  start();
  v1::LoadStateRequest load;
  load.set_name("before the pick");
  v1::LoadStateResponse loaded;
  grpc::ClientContext early;
  const grpc::Status unknown = control_->LoadState(&early, load, &loaded);
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(unknown.error_message().find("before the pick"), std::string::npos);
  v1::SaveStateRequest save;
  save.set_name("before the pick");
  v1::SaveStateResponse saved;
  grpc::ClientContext saving, loading;
  ASSERT_TRUE(control_->SaveState(&saving, save, &saved).ok());
  EXPECT_EQ(saved.receipt().step(), 100U);
  ASSERT_TRUE(control_->LoadState(&loading, load, &loaded).ok());
  EXPECT_EQ(loaded.receipt().epoch(), saved.receipt().epoch() + 1);
  EXPECT_EQ(cell_->commands().size(), 2U);
}

TEST_F(Control, SavedStatesAreListedAndDeleted) {
  start();
  const auto list = [&] {
    v1::ListStatesResponse response;
    grpc::ClientContext context;
    EXPECT_TRUE(control_->ListStates(&context, {}, &response).ok());
    return response;
  };
  const auto remove = [&](const std::string& name) {
    v1::DeleteStateRequest request;
    request.set_name(name);
    v1::DeleteStateResponse response;
    grpc::ClientContext context;
    return control_->DeleteState(&context, request, &response);
  };
  EXPECT_EQ(list().states_size(), 0);
  v1::SaveStateRequest save;
  save.set_name("before the pick");
  v1::SaveStateResponse saved;
  grpc::ClientContext saving;
  ASSERT_TRUE(control_->SaveState(&saving, save, &saved).ok());
  const auto one = list();
  ASSERT_EQ(one.states_size(), 1);
  EXPECT_EQ(one.states(0).name(), "before the pick");
  EXPECT_EQ(one.states(0).step(), 100U);
  EXPECT_EQ(one.states(0).bytes(), 4096U);
  EXPECT_EQ(one.bytes(), 4096U);
  EXPECT_EQ(one.max_bytes(), 1U << 20U);
  const grpc::Status unknown = remove("after the pick");
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(unknown.error_message().find("before the pick"), std::string::npos);
  EXPECT_TRUE(remove("before the pick").ok());
  EXPECT_EQ(list().states_size(), 0);
}

TEST_F(Control, ConveyorLeavesWhatIsAbsent) {
  start();
  v1::SetConveyorRequest request;
  request.set_direction(v1::CONVEYOR_DIRECTION_REVERSE);
  request.set_speed_m_s(0.15);
  request.set_emergency_stop(true);
  request.set_fault_reset(true);
  v1::SetConveyorResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(control_->SetConveyor(&context, request, &response).ok());
  EXPECT_FALSE(response.conveyor().forward());
  EXPECT_EQ(response.conveyor().speed_setting_m_s(), 0.15);
  const auto command = std::get<api::ConveyorCommand>(cell_->commands().at(0).body);
  EXPECT_FALSE(command.run.has_value());
  EXPECT_EQ(command.forward, false);
  EXPECT_EQ(command.emergency_stop, true);
  EXPECT_TRUE(command.fault_reset);
}

TEST_F(Control, TheWayOfPlanningIsSet) {
  start();
  v1::SetPlanningRequest request;
  request.set_robot(cell_->latest()->cell->robots.at(0).name);
  request.set_mode(v1::PLANNING_MODE_AVOID);
  v1::SetPlanningResponse response;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(control_->SetPlanning(&context, request, &response).ok());
  }
  const auto command = std::get<api::RobotCommand>(cell_->commands().at(0).body);
  EXPECT_EQ(command.robot, 0);
  EXPECT_EQ(std::get<api::SetPlanning>(command.action).mode, api::PlanningMode::kAvoid);
  {
    grpc::ClientContext context;
    request.clear_mode();
    const auto status = control_->SetPlanning(&context, request, &response);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  }
  grpc::ClientContext context;
  request.set_robot("nobody");
  const auto status = control_->SetPlanning(&context, request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(status.error_message().find("no robot is named 'nobody'"), std::string::npos);
}

/// Answers with what it was asked.
class FakePreviews final : public api::MovePreviews {
 public:
  void ask(api::PreviewRequest request, Answer answer) override {
    asked.push_back(std::move(request));
    answer(next);
  }
  std::vector<api::PreviewRequest> asked;
  Result<api::MovePreview> next;
};

class MovePreviews : public Control {
 protected:
  MovePreviews() {
    request_.set_robot("fanuc");
    auto& pose = *request_.mutable_tool_in_reference();
    pose.mutable_position_m()->set_x(0.3);
    pose.mutable_orientation()->set_w(1);
    grpc_server::TelemetryOptions options;
    options.previews = &previews_;
    start(options);
  }
  ~MovePreviews() override { server_.reset(); }  // before the previews that it uses

  grpc::Status ask() {
    grpc::ClientContext context;
    return control_->PreviewMove(&context, request_, &response_);
  }
  /// The error of the request as it stands.
  std::string error(grpc::StatusCode code = grpc::StatusCode::INVALID_ARGUMENT) {
    const grpc::Status status = ask();
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    return status.error_message();
  }

  FakePreviews previews_;
  v1::PreviewMoveRequest request_;
  v1::PreviewMoveResponse response_;
};

TEST_F(MovePreviews, PassRequestsAndPlans) {
  request_.set_straight(true);
  request_.set_speed_m_s(0.1);
  request_.set_mode(v1::PLANNING_MODE_CHECK);
  previews_.next->refusal = "the move is blocked";
  previews_.next->touch = {"link_6", "wall", {1, 2, 3}, 1.5};
  previews_.next->mode = api::PlanningMode::kCheck;
  previews_.next->delay_s = 0.02;
  previews_.next->duration_s = 2.25;
  previews_.next->length_m = 0.7;
  previews_.next->spacing_s = 0.02;
  previews_.next->points = {{{0.1, 0.2}, {4, 5, 6}}};
  ASSERT_TRUE(ask().ok());
  const auto& command = previews_.asked.at(0).command;
  EXPECT_EQ(command.robot, 0);
  const auto& move = std::get<api::MoveTo>(command.action);
  EXPECT_TRUE(move.straight);
  EXPECT_EQ(move.X_RT.p.x(), 0.3);
  EXPECT_EQ(move.limits.trans_speed->value, 0.1);
  EXPECT_EQ(previews_.asked.at(0).mode, api::PlanningMode::kCheck);
  EXPECT_FALSE(response_.possible());
  EXPECT_EQ(response_.refusal(), "the move is blocked");
  EXPECT_EQ(response_.touch().other(), "wall");
  EXPECT_EQ(response_.touch().position_m().y(), 2);
  EXPECT_EQ(response_.touch().time().nanos(), 500'000'000);
  EXPECT_EQ(response_.mode(), v1::PLANNING_MODE_CHECK);
  EXPECT_EQ(response_.delay().nanos(), 20'000'000);
  EXPECT_EQ(response_.duration().seconds(), 2);
  EXPECT_EQ(response_.length_m(), 0.7);
  EXPECT_EQ(response_.points(0).joints_rad(1), 0.2);
  EXPECT_EQ(response_.points(0).tool_m().z(), 6);
  EXPECT_TRUE(cell_->commands().empty());
}

TEST_F(MovePreviews, OfJointsHaveTheirSpeed) {
  for (int i = 0; i < 2; ++i) request_.mutable_joints()->add_positions_rad(0.1 * i);
  request_.mutable_joints()->set_speed_rad_s(0.5);
  ASSERT_TRUE(ask().ok());
  const auto& move = std::get<api::MoveJoints>(previews_.asked.at(0).command.action);
  ASSERT_EQ(move.targets.size(), 2U);
  EXPECT_EQ(move.targets[1].position_rad, 0.1);
  EXPECT_EQ(move.targets[1].speed_rad_s, 0.5);
  EXPECT_FALSE(previews_.asked.at(0).mode.has_value());
}

TEST_F(MovePreviews, WrongRequestsNameFieldAndValue) {
  request_.set_speed_m_s(-1);
  EXPECT_EQ(error(), "speed_m_s: -1 m/s is not a speed above 0");
  request_.clear_speed_m_s();
  request_.mutable_tool_in_reference()->mutable_orientation()->set_w(2);
  EXPECT_EQ(error(), "orientation: the quaternion has length 2, expected 1");
  request_.mutable_joints()->add_positions_rad(1);
  EXPECT_EQ(error(), "positions_rad: 1 values, but fanuc has 2 joints");
  request_.mutable_joints()->add_positions_rad(0);
  request_.set_straight(true);
  EXPECT_NE(error().find("straight: true is only valid"), std::string::npos);
  request_.set_straight(false);
  request_.mutable_joints()->set_speed_rad_s(0);
  EXPECT_EQ(error(), "speed_rad_s: 0 rad/s is not a speed above 0");
  request_.set_mode(static_cast<v1::PlanningMode>(9));
  EXPECT_NE(error().find("mode: 9 is not a planning mode"), std::string::npos);
  request_.clear_mode();
  request_.clear_target();
  EXPECT_NE(error().find("target: one of tool_in_reference and joints"), std::string::npos);
  request_.set_robot("nobody");
  EXPECT_NE(error(grpc::StatusCode::NOT_FOUND).find("no robot is named 'nobody'"),
            std::string::npos);
  EXPECT_TRUE(previews_.asked.empty());
}

TEST_F(MovePreviews, ErrorsOfThePlanAreTheAnswer) {
  previews_.next = fail(ErrorCode::kUnavailable, "preview", "too many");
  EXPECT_EQ(error(grpc::StatusCode::UNAVAILABLE), "preview: too many");
}

TEST_F(Control, AReplayHasNoPreviews) {
  start();
  grpc::ClientContext context;
  v1::PreviewMoveResponse response;
  const auto status = control_->PreviewMove(&context, {}, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_NE(status.error_message().find("preview: "), std::string::npos);
}

TEST_F(Control, AnIntruderIsPlacedAndTakenAway) {
  start();
  v1::SetIntruderRequest request;
  auto& intruder = *request.mutable_intruder();
  intruder.mutable_intruder_in_world()->mutable_position_m()->set_y(-1.75);
  intruder.mutable_size_m()->set_x(0.5);
  intruder.mutable_size_m()->set_y(0.3);
  intruder.mutable_size_m()->set_z(1.8);
  v1::SetIntruderResponse response;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(control_->SetIntruder(&context, request, &response).ok());
  }
  EXPECT_TRUE(response.light_curtain().broken());
  EXPECT_GT(response.receipt().ticket(), 0U);
  const auto command = std::get<api::SetIntruder>(cell_->commands().at(0).body);
  ASSERT_TRUE(command.intruder.has_value());
  EXPECT_EQ(command.intruder->X_WI.p.y(), -1.75);
  EXPECT_EQ(command.intruder->X_WI.q.w(), 1) << "upright unless turned";
  EXPECT_EQ(command.intruder->size_m.z(), 1.8);
  v1::GetSnapshotResponse snapshot;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(telemetry_->GetSnapshot(&context, {}, &snapshot).ok());
  }
  EXPECT_EQ(snapshot.snapshot().intruder().intruder_in_world().position_m().y(), -1.75);
  EXPECT_EQ(snapshot.snapshot().intruder().size_m().x(), 0.5);
  grpc::ClientContext context;
  ASSERT_TRUE(control_->SetIntruder(&context, {}, &response).ok());
  EXPECT_FALSE(response.light_curtain().broken());
}

TEST_F(Control, AFaultArrivesAsItWasAskedFor) {
  start();
  v1::InjectFaultRequest request;
  request.set_kind("gripper-leak");
  request.set_target("fanuc");
  (*request.mutable_parameters())["over"] = 5;
  request.mutable_duration()->set_seconds(3);
  request.mutable_duration()->set_nanos(500'000'000);
  auto& crossing = *request.mutable_crossing();
  crossing.set_quantity("joint-position");
  crossing.set_robot("motoman");
  crossing.set_joint(7);
  crossing.set_below(0.5);
  v1::InjectFaultResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(control_->InjectFault(&context, request, &response).ok());
  const auto command = std::get<api::FaultCommand>(cell_->commands().at(0).body);
  const auto& fault = std::get<api::InjectFault>(command);
  EXPECT_EQ(fault.kind, "gripper-leak");
  EXPECT_EQ(fault.target, "fanuc");
  EXPECT_EQ(fault.parameters.at("over"), 5);
  EXPECT_EQ(fault.duration, SimTime(3500ms));
  const auto& when = std::get<api::WhenCrossing>(fault.trigger);
  EXPECT_EQ(when.quantity, faults::Quantity::kJointPosition);
  EXPECT_EQ(when.robot, "motoman");
  EXPECT_EQ(when.joint, 7);
  EXPECT_FALSE(when.above);
  EXPECT_EQ(when.limit, 0.5);
}

TEST_F(Control, ATriggerWithoutItsObjectIsRefused) {
  start();
  const auto code = [&](const v1::InjectFaultRequest& request) {
    v1::InjectFaultResponse response;
    grpc::ClientContext context;
    return control_->InjectFault(&context, request, &response).error_code();
  };
  v1::InjectFaultRequest limitless, unknown, grasps;
  limitless.mutable_crossing()->set_quantity("belt-speed");
  EXPECT_EQ(code(limitless), grpc::StatusCode::INVALID_ARGUMENT);
  unknown.mutable_crossing()->set_quantity("mood");
  unknown.mutable_crossing()->set_above(1);
  EXPECT_EQ(code(unknown), grpc::StatusCode::NOT_FOUND);
  grasps.mutable_grasped()->set_count(4'000'000'000);
  EXPECT_EQ(code(grasps), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_TRUE(cell_->commands().empty());
}

TEST_F(Control, AnIntruderWithoutSizeOrPlaceIsInvalid) {
  start();
  v1::SetIntruderRequest sizeless, placeless;
  sizeless.mutable_intruder()->mutable_intruder_in_world();
  placeless.mutable_intruder()->mutable_size_m()->set_x(1);
  for (const auto& request : {sizeless, placeless}) {
    v1::SetIntruderResponse response;
    grpc::ClientContext context;
    EXPECT_EQ(control_->SetIntruder(&context, request, &response).error_code(),
              grpc::StatusCode::INVALID_ARGUMENT);
  }
  EXPECT_TRUE(cell_->commands().empty());
}

TEST_F(Control, ConveyorSpeedBeyondTheBeltNamesTheLimit) {
  start();
  v1::SetConveyorRequest request;
  request.set_speed_m_s(0.4);
  v1::SetConveyorResponse response;
  grpc::ClientContext context;
  const auto status = control_->SetConveyor(&context, request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_NE(status.error_message().find("0.32768"), std::string::npos) << status.error_message();
}

TEST_F(Control, StepAnswersWhenTheStepsHaveBeenTaken) {
  start();
  cell_->publish([](auto& s) { s.paused = true; });
  const std::uint64_t paused_at = cell_->latest()->step;
  v1::StepRequest request;
  request.set_steps(5);
  v1::StepResponse response;
  std::atomic<bool> answered = false;
  std::jthread client([&] {
    grpc::ClientContext context;
    set_deadline(context, 10s);
    EXPECT_TRUE(control_->Step(&context, request, &response).ok());
    answered = true;
  });
  ASSERT_TRUE(eventually([&] { return !cell_->commands().empty(); }));
  for (int i = 0; i < 4; ++i) cell_->publish([](auto& s) { ++s.step; });
  EXPECT_FALSE(answered);
  cell_->publish([](auto& s) { ++s.step; });
  client.join();
  EXPECT_EQ(response.receipt().step(), paused_at + 5);
  EXPECT_FALSE(response.has_snapshot());
  EXPECT_EQ(simulation_command<api::StepBy>(cell_->commands().at(0))->steps, 5U);
}

TEST_F(Control, StepAnswersWithWhatIsAskedForOfTheCellThere) {
  start();
  cell_->publish([](auto& s) { s.paused = true; });
  const std::uint64_t paused_at = cell_->latest()->step;
  const auto step = [&](const std::vector<std::string>& paths) {
    v1::StepRequest request;
    for (const auto& path : paths) request.mutable_read_mask()->add_paths(path);
    if (paths.empty()) request.mutable_read_mask();
    v1::StepResponse response;
    const std::size_t before = cell_->commands().size();
    std::jthread client([&] {
      grpc::ClientContext context;
      set_deadline(context, 10s);
      EXPECT_TRUE(control_->Step(&context, request, &response).ok());
    });
    EXPECT_TRUE(eventually([&] { return cell_->commands().size() > before; }));
    cell_->publish([](auto& s) { ++s.step; });
    client.join();
    return response;
  };
  EXPECT_EQ(step({"step"}).snapshot().step(), paused_at + 1);
  EXPECT_EQ(step({"step"}).snapshot().robots_size(), 0);
  const v1::StepResponse all = step({});
  EXPECT_EQ(all.snapshot().step(), paused_at + 3);
  EXPECT_EQ(static_cast<std::size_t>(all.snapshot().robots_size()), cell_->latest()->robots.size());

  grpc::ClientContext context;
  v1::StepRequest request;
  request.mutable_read_mask()->add_paths("robots.names");
  v1::StepResponse response;
  const std::size_t before = cell_->commands().size();
  EXPECT_EQ(control_->Step(&context, request, &response).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(cell_->commands().size(), before);
}

TEST_F(Control, StepsOfTwoClientsAddUp) {
  start();
  cell_->publish([](auto& s) { s.paused = true; });
  const std::uint64_t paused_at = cell_->latest()->step;
  v1::StepRequest request;
  request.set_steps(5);
  std::array<v1::StepResponse, 2> responses;
  std::vector<std::jthread> clients;
  for (auto& response : responses) {
    clients.emplace_back([&] {
      grpc::ClientContext context;
      set_deadline(context, 10s);
      EXPECT_TRUE(control_->Step(&context, request, &response).ok());
    });
  }
  ASSERT_TRUE(eventually([&] { return cell_->commands().size() == 2; }));
  cell_->publish([](auto& s) { s.step += 5; });
  cell_->publish([](auto& s) { s.step += 5; });
  for (auto& client : clients) client.join();
  const auto last = std::max(responses[0].receipt().step(), responses[1].receipt().step());
  EXPECT_EQ(last, paused_at + 10);
}

TEST_F(Control, StepNeedsAPausedCell) {
  start();
  grpc::ClientContext context;
  v1::StepResponse response;
  EXPECT_EQ(control_->Step(&context, {}, &response).error_code(),
            grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_TRUE(cell_->commands().empty());
}

TEST_F(Control, StepEndsWhenTheCellIsResetOrFails) {
  start();
  cell_->publish([](auto& s) { s.paused = true; });
  const auto step_until = [&](const std::function<void(api::Snapshot&)>& change) {
    grpc::Status status;
    const auto before = cell_->commands().size();
    std::jthread client([&] {
      grpc::ClientContext context;
      set_deadline(context, 10s);
      v1::StepResponse response;
      status = control_->Step(&context, {}, &response);
    });
    EXPECT_TRUE(eventually([&] { return cell_->commands().size() > before; }));
    cell_->publish(change);
    client.join();
    return status;
  };
  EXPECT_EQ(step_until([](auto& s) { ++s.epoch; }).error_code(), grpc::StatusCode::ABORTED);
  const auto fault = step_until([](auto& s) { s.world_fault = "gear_1 left the cell"; });
  EXPECT_EQ(fault.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(fault.error_message(), "gear_1 left the cell");
}

TEST_F(Control, ACancelledStepStopsStepping) {
  start();
  cell_->publish([](auto& s) { s.paused = true; });
  grpc::ClientContext context;
  set_deadline(context, 20s);
  v1::StepRequest request;
  request.set_steps(10'000'000);
  std::jthread client([&] {
    v1::StepResponse response;
    EXPECT_EQ(control_->Step(&context, request, &response).error_code(),
              grpc::StatusCode::CANCELLED);
  });
  ASSERT_TRUE(cell_->wait_for_commands(1));
  context.TryCancel();
  client.join();
  ASSERT_TRUE(cell_->wait_for_commands(2));
  EXPECT_TRUE(std::holds_alternative<api::Pause>(
      std::get<api::SimulationCommand>(cell_->commands().at(1).body)));
}

/// The simulation has taken the command but could not carry it out.
TEST_F(Control, ACommandThatFailsIsAnErrorForItsSender) {
  start();
  cell_->hold();
  grpc::Status status;
  std::jthread client([&] {
    grpc::ClientContext context;
    set_deadline(context, 10s);
    v1::SaveStateRequest request;
    request.set_name("here");
    v1::SaveStateResponse response;
    status = control_->SaveState(&context, request, &response);
  });
  ASSERT_TRUE(cell_->wait_for_commands(1));
  cell_->publish([](auto& s) {
    s.failures = std::make_shared<const std::vector<api::CommandFailure>>(
        1, api::CommandFailure{1, {ErrorCode::kUnavailable, "simulation", "no memory is left"}});
    s.applied = 1;
  });
  client.join();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_NE(status.error_message().find("no memory is left"), std::string::npos);
}

TEST_F(Control, CommandWithoutEffectEndsAtTheDeadline) {
  start({.command_timeout = 100ms});
  cell_->hold();
  v1::ResumeResponse response;
  grpc::ClientContext server_deadline;
  EXPECT_EQ(control_->Resume(&server_deadline, {}, &response).error_code(),
            grpc::StatusCode::DEADLINE_EXCEEDED);
  grpc::ClientContext client_deadline;
  set_deadline(client_deadline, 50ms);
  EXPECT_EQ(control_->Resume(&client_deadline, {}, &response).error_code(),
            grpc::StatusCode::DEADLINE_EXCEEDED);
}

TEST_F(Control, RefusalsKeepTheirKindFieldAndReason) {
  start();
  cell_->refuse(Error{ErrorCode::kUnavailable, "queue", "the command queue is full"});
  v1::PauseResponse response;
  grpc::ClientContext context;
  const auto status = control_->Pause(&context, {}, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(status.error_message(), "queue: the command queue is full");
}

}  // namespace
}  // namespace aprsim::test
