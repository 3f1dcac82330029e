#include <cmath>
#include <limits>

#include "tests/unit/protocols/grpc/telemetry_fixture.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;
using Reading = TelemetryFixture;

TEST_F(Reading, SnapshotCarriesTheCell) {
  start({.instance_id = "cell-7"});
  grpc::ClientContext context;
  v1::GetSnapshotResponse response;
  ASSERT_TRUE(telemetry_->GetSnapshot(&context, {}, &response).ok());
  const auto& snapshot = response.snapshot();
  EXPECT_EQ(snapshot.instance_id(), "cell-7");
  EXPECT_EQ(snapshot.step(), 100U);
  EXPECT_EQ(snapshot.sim_time().nanos(), 100'000'000);
  EXPECT_EQ(snapshot.speed_target(), 1.0);
  ASSERT_EQ(snapshot.robots_size(), 1);
  const auto& robot = snapshot.robots(0);
  EXPECT_EQ(robot.name(), "fanuc");
  ASSERT_EQ(robot.joints_size(), 2);
  EXPECT_EQ(robot.joints(1).position_rad(), 0.25);
  EXPECT_EQ(robot.gripper().separation_m(), 0.0077);
  EXPECT_EQ(robot.gripper().held_body(), "gear_1");
  EXPECT_EQ(robot.gripper().held_index(), 0u);
  EXPECT_EQ(robot.gripper().held_kind(), v1::BODY_KIND_GEAR);
  ASSERT_EQ(robot.gripper().force_n_size(), 2);
  EXPECT_EQ(robot.gripper().force_n(1), 61);
  EXPECT_EQ(robot.action().state(), v1::ACTION_STATE_NONE);
  ASSERT_EQ(snapshot.bodies_size(), 2);
  EXPECT_EQ(snapshot.bodies(0).type(), "sku_part_large_gear");
  EXPECT_EQ(snapshot.bodies(0).body_in_world().position_m().y(), -1.0);
  EXPECT_EQ(snapshot.bodies(0).body_in_world().orientation().w(), 1.0);
  EXPECT_TRUE(snapshot.bodies(1).resting());
  EXPECT_EQ(snapshot.bodies(0).group_kind(), v1::GROUP_KIND_UNSPECIFIED);
  EXPECT_FALSE(snapshot.bodies(0).has_group());
  EXPECT_EQ(snapshot.bodies(1).group_kind(), v1::GROUP_KIND_MERGED);
  EXPECT_EQ(snapshot.bodies(1).group(), 0u);
  EXPECT_EQ(snapshot.contact_count(), 12U);
  EXPECT_EQ(robot.action().kind(), v1::ACTION_KIND_MOVE_TO);
  EXPECT_EQ(robot.goal_in_reference().position_m().x(), 0.3);
  ASSERT_EQ(snapshot.contacts_size(), 2);
  EXPECT_EQ(snapshot.contacts(0).first().robot(), 0U);
  EXPECT_TRUE(snapshot.contacts(0).first().has_robot());
  EXPECT_EQ(snapshot.contacts(0).first().part(), "finger_2");
  EXPECT_TRUE(snapshot.contacts(0).second().has_body());
  EXPECT_EQ(snapshot.contacts(0).second().part(), "");
  EXPECT_EQ(snapshot.contacts(0).force_n().y(), 60);
  EXPECT_EQ(snapshot.contacts(1).second().fixed(), 1U);
  EXPECT_EQ(snapshot.contacts(1).point_m().z(), 0.93);
}

TEST_F(Reading, SnapshotCarriesWhatIsLostAndWhatTheSolverFailedAt) {
  start();
  cell_->publish([](api::Snapshot& s) {
    s.bodies[0].lost_step = 4711;
    s.robots[0].gripper.holding = false;
    s.robots[0].gripper.held_body = -1;
    s.solver_failures = {.not_converged = 2, .max_residual_m_s = 3e-9};
    s.solver_step = {.iterations = 7, .residual_m_s = 2e-10};
    s.world_stops = 5;
  });
  v1::GetSnapshotResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(telemetry_->GetSnapshot(&context, {}, &response).ok());
  const auto& snapshot = response.snapshot();
  EXPECT_EQ(snapshot.bodies(0).lost_step(), 4711u);
  EXPECT_FALSE(snapshot.bodies(1).has_lost_step());
  EXPECT_FALSE(snapshot.robots(0).gripper().has_held_index());
  EXPECT_EQ(snapshot.robots(0).gripper().held_kind(), v1::BODY_KIND_UNSPECIFIED);
  EXPECT_EQ(snapshot.solver_failures().not_converged(), 2u);
  EXPECT_EQ(snapshot.solver_failures().max_residual_m_s(), 3e-9);
  EXPECT_EQ(snapshot.solver_step().iterations(), 7u);
  EXPECT_EQ(snapshot.solver_step().residual_m_s(), 2e-10);
  EXPECT_EQ(snapshot.world_stops(), 5u);
}

TEST_F(Reading, CellDescriptionCarriesGeometry) {
  start();
  grpc::ClientContext context;
  v1::GetCellResponse response;
  ASSERT_TRUE(telemetry_->GetCell(&context, {}, &response).ok());
  const auto& cell = response.cell();
  EXPECT_EQ(cell.scene(), "fake");
  ASSERT_EQ(cell.fixed_size(), 2);
  EXPECT_EQ(cell.fixed(1), "table");
  EXPECT_EQ(cell.robots(0).joints(1).upper_rad(), 2.5);
  EXPECT_EQ(cell.robots(0).base_in_world().position_m().x(), -0.169);
  EXPECT_EQ(cell.conveyor().max_speed_m_s(), 0.32768);
  EXPECT_EQ(cell.conveyor().max_decel_m_s2(), 0.6);
  EXPECT_EQ(cell.conveyor().emergency_decel_m_s2(), 2);
  ASSERT_EQ(cell.conveyor().photo_eyes_size(), 1);
  EXPECT_EQ(cell.conveyor().photo_eyes(0).name(), "eye");
  EXPECT_EQ(cell.conveyor().photo_eyes(0).x_m(), 1);
  EXPECT_EQ(cell.bodies(0).gear().peg_top_m(), 0.026);
  ASSERT_TRUE(cell.bodies(1).has_tray());
  EXPECT_EQ(cell.bodies(1).kind(), v1::BODY_KIND_KIT_TRAY);
  EXPECT_EQ(cell.bodies(1).tray().slots(0).slot_in_tray().position_m().x(), 0.039);
}

TEST_F(Reading, SnapshotCarriesTheDrivesFaultAndItsSensors) {
  start();
  cell_->publish([](api::Snapshot& s) {
    s.conveyor.emergency_stop = true;
    s.conveyor.fault = api::DriveFault::kEmergencyStop;
    s.conveyor.motor_current_a = 0.25;
    s.conveyor.load_kg = 1.5;
    s.conveyor.photo_eyes[0] = {.broken = true, .count = 7};
  });
  v1::GetSnapshotResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(telemetry_->GetSnapshot(&context, {}, &response).ok());
  const auto& conveyor = response.snapshot().conveyor();
  EXPECT_TRUE(conveyor.emergency_stop());
  EXPECT_EQ(conveyor.fault(), v1::DRIVE_FAULT_EMERGENCY_STOP);
  EXPECT_EQ(conveyor.motor_current_a(), 0.25);
  EXPECT_EQ(conveyor.load_kg(), 1.5);
  ASSERT_EQ(conveyor.photo_eyes_size(), 1) << "as many as the cell has";
  EXPECT_TRUE(conveyor.photo_eyes(0).broken());
  EXPECT_EQ(conveyor.photo_eyes(0).count(), 7U);
}

TEST_F(Reading, TheLightCurtainShowsItsOutputBeamsAndReaction) {
  start();
  cell_->publish([](api::Snapshot& s) {
    s.light_curtain = {.broken = true, .distance_m = {2.4, 0.75, 2.4, 99}};
    s.conveyor.fault = api::DriveFault::kLightCurtain;
  });
  v1::GetSnapshotResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(telemetry_->GetSnapshot(&context, {}, &response).ok());
  const auto& curtain = response.snapshot().light_curtain();
  EXPECT_TRUE(curtain.broken());
  ASSERT_EQ(curtain.distance_m_size(), 3) << "as many as it has beams";
  EXPECT_EQ(curtain.distance_m(1), 0.75);
  EXPECT_EQ(response.snapshot().conveyor().fault(), v1::DRIVE_FAULT_LIGHT_CURTAIN);
  EXPECT_FALSE(response.snapshot().has_intruder());
  v1::GetCellResponse cell;
  grpc::ClientContext cell_context;
  ASSERT_TRUE(telemetry_->GetCell(&cell_context, {}, &cell).ok());
  const auto& description = cell.cell().light_curtain();
  EXPECT_EQ(description.curtain_in_world().position_m().y(), -1.75);
  EXPECT_EQ(description.beams(), 3U);
  EXPECT_EQ(description.pitch_m(), 0.04);
  EXPECT_EQ(description.range_m(), 2.4);
  EXPECT_EQ(description.reaction(), v1::CURTAIN_REACTION_BELT_STOP);
}

TEST_F(Reading, MaskSelectsFields) {
  start();
  v1::GetSnapshotRequest request;
  request.mutable_read_mask()->add_paths("conveyor");
  v1::GetSnapshotResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(telemetry_->GetSnapshot(&context, request, &response).ok());
  EXPECT_TRUE(response.snapshot().has_conveyor());
  EXPECT_EQ(response.snapshot().bodies_size(), 0);
  EXPECT_EQ(response.snapshot().step(), 0U);
}

TEST_F(Reading, MaskSelectsFieldsOfFields) {
  start();
  v1::GetSnapshotRequest request;
  for (const char* path :
       {"robots.joints.position_rad", "robots.gripper", "robots.name", "robots.gripper.holding",
        "conveyor.photo_eyes.count", "sim_time.nanos", "contacts.first"}) {
    request.mutable_read_mask()->add_paths(path);
  }
  v1::GetSnapshotResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(telemetry_->GetSnapshot(&context, request, &response).ok());
  const auto& snapshot = response.snapshot();
  ASSERT_EQ(snapshot.robots_size(), 1);
  const auto& robot = snapshot.robots(0);
  EXPECT_EQ(robot.name(), "fanuc");
  EXPECT_FALSE(robot.has_tool_in_world());
  ASSERT_EQ(robot.joints_size(), 2);
  EXPECT_EQ(robot.joints(1).position_rad(), 0.25);
  EXPECT_EQ(robot.joints(1).torque_nm(), 0);
  // Asked for whole, and a part of it besides: whole.
  EXPECT_EQ(robot.gripper().held_body(), "gear_1");
  EXPECT_EQ(snapshot.conveyor().photo_eyes_size(), 1);
  EXPECT_EQ(snapshot.conveyor().speed_setting_m_s(), 0);
  EXPECT_EQ(snapshot.bodies_size(), 0);
  EXPECT_EQ(snapshot.sim_time().nanos(), 100'000'000);
  ASSERT_EQ(snapshot.contacts_size(), 2);
  EXPECT_EQ(snapshot.contacts(0).first().part(), "finger_2");
  EXPECT_FALSE(snapshot.contacts(0).has_second());
}

TEST_F(Reading, EntitiesSelectThingsAndTheirContacts) {
  start();
  v1::GetSnapshotRequest request;
  request.add_entities("kit_1");
  v1::GetSnapshotResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(telemetry_->GetSnapshot(&context, request, &response).ok());
  const auto& snapshot = response.snapshot();
  EXPECT_EQ(snapshot.robots_size(), 0);
  ASSERT_EQ(snapshot.bodies_size(), 1);
  EXPECT_EQ(snapshot.bodies(0).name(), "kit_1");
  for (const auto& contact : snapshot.contacts()) {
    EXPECT_TRUE(contact.first().body() == 1 || contact.second().body() == 1);
  }
  EXPECT_TRUE(snapshot.has_conveyor());

  request.add_entities("nothing");
  grpc::ClientContext another;
  const auto status = telemetry_->GetSnapshot(&another, request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(status.error_message().find("'nothing'"), std::string::npos);
}

TEST_F(Reading, UnknownMaskPathIsRefusedByName) {
  start();
  for (const char* path : {"robot", "robots.joint", "robots.joints.position_rad.x", "", "robots.",
                           ".robots", "injected_faults.parameters.value"}) {
    v1::GetSnapshotRequest request;
    request.mutable_read_mask()->add_paths(path);
    v1::GetSnapshotResponse response;
    grpc::ClientContext context;
    const auto status = telemetry_->GetSnapshot(&context, request, &response);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_NE(status.error_message().find("'" + std::string(path) + "' leads nowhere"),
              std::string::npos)
        << status.error_message();
  }
}

TEST_F(Reading, StreamKeepsTheRateAskedFor) {
  start();
  v1::StreamSnapshotsRequest request;
  request.set_rate_hz(25);
  grpc::ClientContext context;
  const auto reader = telemetry_->StreamSnapshots(&context, request);
  v1::StreamSnapshotsResponse response;
  std::uint64_t samples = 0;
  const auto read = [&] {
    EXPECT_TRUE(reader->Read(&response));
    EXPECT_EQ(response.effective_rate_hz(), 25);
    EXPECT_EQ(response.sequence(), ++samples + response.dropped_count());
  };
  double rate = 0;
  // A busy machine may be late now and then, not always.
  EXPECT_TRUE(eventually(
      [&] {
        read();
        const auto first = response.sequence();
        const auto begin = std::chrono::steady_clock::now();
        for (int i = 0; i < 25; ++i) read();
        const std::chrono::duration<double> span = std::chrono::steady_clock::now() - begin;
        // Samples lost to a slow reader still take up their number.
        rate = static_cast<double>(response.sequence() - first) / span.count();
        return std::abs(rate - 25) < 3;
      },
      40s))
      << rate;
  context.TryCancel();
}

TEST_F(Reading, StreamWithoutARateUsesTheDefault) {
  start({.default_rate_hz = 250});
  grpc::ClientContext context;
  const auto reader = telemetry_->StreamSnapshots(&context, {});
  v1::StreamSnapshotsResponse response;
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_EQ(response.effective_rate_hz(), 250);
  EXPECT_EQ(response.sequence(), 1U);
  context.TryCancel();
}

TEST_F(Reading, BadRatesAreInvalid) {
  start();
  for (const double rate : {1000.5, -1.0, std::numeric_limits<double>::infinity(),
                            std::numeric_limits<double>::quiet_NaN()}) {
    v1::StreamSnapshotsRequest request;
    request.set_rate_hz(rate);
    grpc::ClientContext context;
    const auto reader = telemetry_->StreamSnapshots(&context, request);
    v1::StreamSnapshotsResponse response;
    EXPECT_FALSE(reader->Read(&response)) << rate;
    const auto status = reader->Finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << rate;
    EXPECT_NE(status.error_message().find("rate_hz"), std::string::npos);
  }
}

TEST_F(Reading, SlowReaderLosesSamplesAndIsToldHowMany) {
  start({}, 300);  // some 40 kB a sample: the transport's buffers fill soon
  v1::StreamSnapshotsRequest request;
  request.set_rate_hz(1000);
  grpc::ClientContext slow_context, quick_context;
  const auto slow = telemetry_->StreamSnapshots(&slow_context, request);
  request.mutable_read_mask()->add_paths("conveyor");
  const auto other = v1::TelemetryService::NewStub(new_channel());
  const auto quick = other->StreamSnapshots(&quick_context, request);
  v1::StreamSnapshotsResponse response;
  std::uint64_t sequence = 0, dropped = 0;
  int dawdled = 100, losses = 0;
  const bool lost = eventually(
      [&] {
        // Another client gets so many samples while this one reads none.
        for (int i = 0; i < dawdled; ++i) EXPECT_TRUE(quick->Read(&response));
        std::uint64_t gap = 0;
        for (int i = 0; i < dawdled && gap == 0; ++i) {
          if (!slow->Read(&response)) return true;
          gap = response.sequence() - sequence - 1;
          EXPECT_EQ(gap, response.dropped_count() - dropped);
          sequence = response.sequence();
          dropped = response.dropped_count();
        }
        if (gap > 0) {
          ++losses;
        } else {
          dawdled *= 2;  // the buffers had room for all of them
        }
        return losses >= 5;
      },
      100s);
  EXPECT_TRUE(lost);
  EXPECT_GE(losses, 5);
  slow_context.TryCancel();
  quick_context.TryCancel();
}

TEST_F(Reading, TooManyStreamsAreRefused) {
  start({.max_streams = 1});
  grpc::ClientContext first_context;
  const auto first = telemetry_->StreamSnapshots(&first_context, {});
  v1::StreamSnapshotsResponse response;
  ASSERT_TRUE(first->Read(&response));
  {
    grpc::ClientContext context;
    const auto second = telemetry_->StreamSnapshots(&context, {});
    EXPECT_FALSE(second->Read(&response));
    EXPECT_EQ(second->Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  }
  first_context.TryCancel();
  // A stream that ended makes room.
  EXPECT_TRUE(eventually([&] {
    grpc::ClientContext context;
    const auto next = telemetry_->StreamSnapshots(&context, {});
    const bool served = next->Read(&response);
    context.TryCancel();
    return served;
  }));
}

TEST_F(Reading, StreamStuckInOneWriteIsEnded) {
  start({.max_streams = 1, .write_timeout = 300ms}, 300);
  v1::StreamSnapshotsRequest request;
  request.set_rate_hz(1000);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
  const auto reader = telemetry_->StreamSnapshots(&context, request);
  v1::StreamSnapshotsResponse response;
  ASSERT_TRUE(reader->Read(&response));
  // It reads no more; its place becomes free although it does not go away.
  const auto other = v1::TelemetryService::NewStub(new_channel());
  ASSERT_TRUE(eventually([&] {
    grpc::ClientContext other_context;
    other_context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(2));
    const auto next = other->StreamSnapshots(&other_context, {});
    const bool served = next->Read(&response);
    other_context.TryCancel();
    return served;
  }));
  while (reader->Read(&response)) {
  }
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

}  // namespace
}  // namespace aprsim::test
