// Changes of the scene of a running cell.

#include "world/cell/scene_editor.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/support/eventually.hpp"
#include "tests/support/pick_place.hpp"
#include "world/cell/commands/command_check.hpp"
#include "world/runtime/simulation.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;
using WorldPtr = std::unique_ptr<world::World>;

WorldPtr cell_of(const std::string& scene = "aprs") {
  return std::make_unique<world::World>(load_scene(scene), 1);
}

void advance_world(world::World& world, int steps) {
  for (; steps > 0; --steps) world.step();
}

api::Snapshot picture(const world::World& world) {
  api::Snapshot now;
  world.write(now);
  return now;
}

int index_of(const world::World& world, const std::string& name) {
  const auto& bodies = world.description()->bodies;
  const auto found = std::ranges::find(bodies, name, &api::BodyDescription::name);
  return found == bodies.end() ? -1 : static_cast<int>(found - bodies.begin());
}

const api::BodySnapshot& body_in(const api::Snapshot& now, const std::string& name) {
  const auto& bodies = now.cell->bodies;
  const auto found = std::ranges::find(bodies, name, &api::BodyDescription::name);
  return now.bodies.at(static_cast<std::size_t>(found - bodies.begin()));
}

Error edit_refusal(WorldPtr& world, const api::SceneCommand& command) {
  api::Command checked{.body = command};
  auto done = world::check(checked, world->description());
  if (done) done = world::SceneEditor(world).apply(command);
  EXPECT_FALSE(done);
  return done ? Error{} : done.error();
}

TEST(SceneEditor, AddsBodiesUpToALimitThatRemovalDoesNotRaise) {
  WorldPtr world = cell_of("empty_belt");
  const auto spawn = [&](std::size_t number) {
    const Pose at{.p = {-1, 0.2 * static_cast<double>(number), 5}};
    return api::SpawnBody{"sku_part_large_gear", "spare_" + std::to_string(number), at};
  };
  for (std::size_t i = 0; i < api::kMaxAddedBodies; ++i) {
    const auto done = world::SceneEditor(world).apply(spawn(i));
    ASSERT_TRUE(done) << i << ": " << done.error().message;
  }
  const Error refused = edit_refusal(world, spawn(api::kMaxAddedBodies));
  EXPECT_EQ(refused.code, ErrorCode::kFailedPrecondition);
  EXPECT_NE(refused.message.find("the limit is 100"), std::string::npos) << refused.message;
  ASSERT_TRUE(world::SceneEditor(world).apply(api::RemoveBody{"spare_0"}));
  EXPECT_EQ(edit_refusal(world, spawn(api::kMaxAddedBodies)).code, ErrorCode::kFailedPrecondition);
}

TEST(SceneEditor, EqualValueChangesNoBit) {
  WorldPtr edited = cell_of(), left = cell_of();
  for (auto* world : {edited.get(), left.get()}) {
    world->apply(1, api::RobotCommand{0, api::InitRobot{}, {}});
    advance_world(*world, 300);
    world->apply(2, api::RobotCommand{0, api::MoveJoints{{{.joint = 0, .position_rad = 0.7}}}, {}});
    world->apply(
        3,
        api::ConveyorCommand{
            .run = true, .forward = {}, .speed_m_s = 0.2, .emergency_stop = {}, .watchdog_s = {}});
    advance_world(*world, 200);
  }
  ASSERT_TRUE(
      world::SceneEditor(edited).apply(api::SetSceneValue{"physics.friction.gear_tray", "0.35"}));
  ASSERT_NE(edited->scene(), left->scene());
  advance_world(*edited, 1500);
  advance_world(*left, 1500);
  EXPECT_EQ(edited->state_hash(), left->state_hash());
}

TEST(SceneEditor, ChangesValues) {
  WorldPtr world = cell_of();
  advance_world(*world, 100);
  const std::string path = "gear_types.sku_part_large_gear.mass_kg";
  ASSERT_TRUE(world::SceneEditor(world).apply(api::SetSceneValue{path, "0.5"}));
  for (const auto& body : world->description()->bodies) {
    if (body.type == "sku_part_large_gear") {
      EXPECT_EQ(body.mass_kg, 0.5);
    }
  }
  ASSERT_TRUE(world::SceneEditor(world).apply(
      api::SetSceneValue{"robots.fanuc.vision.position_noise_m", "0.002"}));
  EXPECT_EQ(world->scene()->robots[0].vision.position_noise_m, 0.002);
  EXPECT_EQ(world->step_count(), 100u);
  advance_world(*world, 500);
}

TEST(SceneEditor, ChecksValuesLikeASceneFile) {
  WorldPtr world = cell_of();
  advance_world(*world, 10);
  const auto message = [&](const std::string& path, const std::string& value) {
    return edit_refusal(world, api::SetSceneValue{path, value}).message;
  };
  const auto has = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  has(message("physics.friction.gear_tray", "-1"), "physics.friction.gear_tray: found -1");
  has(message("physics.friction.gear_trays", "1"), "gear_trays");
  has(message("gear_types.sku_part_large_gear.mass_kg", "heavy"), "expected");
  has(message("gear_types.nothing.mass_kg", "1"), "there is no 'nothing'");
  has(message("robots.nobody.vision.shuffle", "true"), "there is no 'nobody'");
  for (const char* path :
       {"physics.step_s", "physics.simplification", "robots.fanuc.base.xyz_m", "conveyor.length_m",
        "seed", "trays", "physics", "physics..friction", "robots.fanuc.vision.rate_hz"}) {
    has(message(path, "1"), "cannot be changed in a running cell");
  }
  has(message("", "1"), "0 bytes");
  EXPECT_EQ(world->step_count(), 10u);
}

TEST(SceneEditor, SpawnsBodiesWithoutChangingTheRest) {
  WorldPtr worlds[2] = {cell_of(), cell_of()};
  std::uint64_t hashes[2] = {};
  for (int i = 0; i < 2; ++i) {
    WorldPtr& world = worlds[i];
    world->watch_events();
    advance_world(*world, 300);
    world->apply(1, api::RobotCommand{1, api::InitRobot{}, {}});
    advance_world(*world, 20);
    world->apply(2, api::RobotCommand{1, api::MoveJoints{{{.joint = 0, .position_rad = 0.4}}}, {}});
    advance_world(*world, 200);
    const api::Snapshot before = picture(*world);
    Pose at;
    at.p = {-0.2, -1.35, 1.1};
    ASSERT_TRUE(
        world::SceneEditor(world).apply(api::SpawnBody{"sku_part_large_gear", "spare", at}));
    at.p = {-0.39, -0.9, 0.97};
    ASSERT_TRUE(
        world::SceneEditor(world).apply(api::SpawnBody{"sku_kit_m2l1_vessel", "spare_kit", at}));
    const api::Snapshot after = picture(*world);
    ASSERT_EQ(after.bodies.size(), before.bodies.size() + 2);
    EXPECT_EQ(after.step, before.step);
    for (const auto& body : before.cell->bodies) {
      EXPECT_EQ(body_in(after, body.name).X_WB.p, body_in(before, body.name).X_WB.p) << body.name;
    }
    EXPECT_EQ(after.robots[1].action.state, api::ActionState::kWorking);
    EXPECT_EQ(after.robots[1].joints[0].position_rad, before.robots[1].joints[0].position_rad);
    advance_world(*world, 3000);
    const api::Snapshot end = picture(*world);
    EXPECT_EQ(end.robots[1].action.state, api::ActionState::kDone)
        << end.robots[1].action.description;
    EXPECT_EQ(end.physics_faults, before.physics_faults);
    for (const auto& body : before.cell->bodies) {
      const double moved =
          (body_in(end, body.name).X_WB.p - body_in(before, body.name).X_WB.p).norm();
      EXPECT_LT(moved, 1e-2) << body.name;
    }
    EXPECT_TRUE(body_in(end, "spare_kit").resting);
    EXPECT_LT(body_in(end, "spare").X_WB.p.z(), 1.1);
    hashes[i] = world->state_hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(SceneEditor, KeepsGraspsWhileBodiesAreSpawned) {
  const auto edit = [&](WorldPtr& world) {
    Pose at;
    at.p = {-0.39, -0.9, 0.97};
    EXPECT_TRUE(
        world::SceneEditor(world).apply(api::SpawnBody{"sku_kit_m2l1_vessel", "spare_kit", at}));
  };
  WorldPtr world = cell_of();
  // A grasp by the same commands as the script's, without its looks.
  const auto& fanuc = world->description()->robots[0];
  const Eigen::Isometry3d X_RW = (fanuc.X_WB.isometry() * fanuc.X_BR.isometry()).inverse();
  const int gear = index_of(*world, "part_large_gear_1");
  const auto pose = picture(*world).bodies[static_cast<std::size_t>(gear)].X_WB.isometry();
  const double grip_z =
      world->description()->bodies[static_cast<std::size_t>(gear)].disc_height_m + 0.004;
  const Eigen::Vector3d grip = pose * Eigen::Vector3d(0, 0, grip_z), up(0, 0, 0.06);
  api::Ticket ticket = 0;
  const auto act = [&](const api::RobotAction& action) {
    world->apply(++ticket, api::RobotCommand{0, action, {}});
    for (int i = 0; i < 20'000; ++i) {
      world->step();
      if (picture(*world).robots[0].action.state == api::ActionState::kDone) return;
    }
    ADD_FAILURE() << picture(*world).robots[0].action.description;
  };
  act(api::InitRobot{});
  act(api::MoveTo{Pose::from(X_RW * tool_down(grip + up, 0)), false});
  act(api::MoveTo{Pose::from(X_RW * tool_down(grip, 0)), true});
  act(api::SetGripper{0});
  act(api::MoveTo{Pose::from(X_RW * tool_down(grip + up, 0)), true});
  const api::Snapshot before = picture(*world);
  ASSERT_TRUE(before.robots[0].gripper.holding);
  edit(world);
  const api::Snapshot after = picture(*world);
  ASSERT_TRUE(after.robots[0].gripper.holding);
  EXPECT_EQ(after.cell->bodies[static_cast<std::size_t>(after.robots[0].gripper.held_body)].name,
            "part_large_gear_1");
  act(api::Dwell{500ms});
  const api::Snapshot end = picture(*world);
  EXPECT_TRUE(end.robots[0].gripper.holding);
  EXPECT_FALSE(end.robots[0].protective_stop);
  EXPECT_LT((body_in(end, "part_large_gear_1").X_WB.p - body_in(before, "part_large_gear_1").X_WB.p)
                .norm(),
            5e-4);
}

TEST(SceneEditor, MovesAndRemovesBodies) {
  WorldPtr world = cell_of();
  world->watch_events();
  advance_world(*world, 300);
  Pose at;
  at.p = {-0.39, -0.9, 0.97};
  ASSERT_TRUE(world::SceneEditor(world).apply(api::MoveBody{"part_large_gear_1", at}));
  EXPECT_LT((body_in(picture(*world), "part_large_gear_1").X_WB.p - at.p).norm(), 1e-12);
  // Where something is already, it lies above.
  at = body_in(picture(*world), "large_gear_vessel_1").X_WB;
  ASSERT_TRUE(world::SceneEditor(world).apply(api::MoveBody{"part_medium_gear_1", at}));
  EXPECT_GT(body_in(picture(*world), "part_medium_gear_1").X_WB.p.z(), at.p.z());
  ASSERT_TRUE(world::SceneEditor(world).apply(api::RemoveBody{"part_large_gear_2"}));
  EXPECT_TRUE(body_in(picture(*world), "part_large_gear_2").lost_step);
  advance_world(*world, 1000);
  std::vector<std::string> edits;
  for (const auto& event : *world->events()) {
    if (event.kind == api::CellEventKind::kEdited) {
      edits.push_back(event.names.at(0) + " " + event.text);
    }
  }
  EXPECT_EQ(edits, (std::vector<std::string>{"part_large_gear_1 moved", "part_medium_gear_1 moved",
                                             "part_large_gear_2 removed"}));
  EXPECT_EQ(edit_refusal(world, api::RemoveBody{"part_large_gear_2"}).code,
            ErrorCode::kFailedPrecondition);
  EXPECT_EQ(edit_refusal(world, api::MoveBody{"nothing", at}).code, ErrorCode::kNotFound);
  at.p.x() = 1e9;
  EXPECT_EQ(edit_refusal(world, api::MoveBody{"part_large_gear_1", at}).field, "position");
  at.p.x() = 0;
  EXPECT_EQ(edit_refusal(world, api::SpawnBody{"nothing", "spare", at}).code, ErrorCode::kNotFound);
  const Error twice =
      edit_refusal(world, api::SpawnBody{"sku_part_large_gear", "part_large_gear_1", at});
  EXPECT_NE(twice.message.find("a second body part_large_gear_1"), std::string::npos)
      << twice.message;
  const Error name = edit_refusal(world, api::SpawnBody{"sku_part_large_gear", "a b", at});
  EXPECT_NE(name.message.find("a b"), std::string::npos) << name.message;
}

class EditedSimulation : public testing::Test {
 protected:
  EditedSimulation() : simulation(load_scene("aprs"), {.paused = true}) { simulation.start(); }

  api::SnapshotPtr command(decltype(api::Command::body) body) {
    const auto ticket = simulation.submit({.endpoint = 1, .body = std::move(body)});
    if (!ticket) {
      refused = ticket.error();
      return simulation.latest();
    }
    EXPECT_TRUE(eventually([&] { return simulation.latest()->applied >= *ticket; }));
    const auto now = simulation.latest();
    if (now->failures) {
      for (const auto& failure : *now->failures) {
        if (failure.ticket == *ticket) refused = failure.error;
      }
    }
    return now;
  }
  world::Simulation simulation;
  Error refused;
};

TEST_F(EditedSimulation, SavedStatesKeepChangesAndResetsUndoThem) {
  Pose at;
  at.p = {-0.39, -0.9, 0.97};
  const auto start = command(api::SimulationCommand(api::StepBy{50}));
  const std::size_t bodies = start->bodies.size();
  command(api::SimulationCommand(api::SaveState{"before"}));
  const auto spawned =
      command(api::SceneCommand(api::SpawnBody{"sku_part_large_gear", "spare", at}));
  EXPECT_EQ(spawned->bodies.size(), bodies + 1);
  EXPECT_EQ(spawned->epoch, start->epoch);
  EXPECT_GT(spawned->cell->revision, start->cell->revision);
  EXPECT_NE(spawned->cell->scene_text->find("spare"), std::string::npos);
  command(api::SimulationCommand(api::SaveState{"after"}));
  EXPECT_EQ(command(api::SimulationCommand(api::LoadState{"before"}))->bodies.size(), bodies);
  const auto again = command(api::SimulationCommand(api::LoadState{"after"}));
  EXPECT_EQ(again->bodies.size(), bodies + 1);
  EXPECT_EQ(again->cell->bodies.back().name, "spare");
  const auto reset = command(api::SimulationCommand(api::Reset{}));
  EXPECT_EQ(reset->bodies.size(), bodies);
  EXPECT_GT(reset->cell->revision, again->cell->revision);
  EXPECT_EQ(refused.message, "");
}

TEST_F(EditedSimulation, ResetsToAnotherSceneOfTheSameRobots) {
  api::Reset other;
  other.scene_name = "aprs_2024";
  const auto there = command(api::SimulationCommand(other));
  ASSERT_EQ(refused.message, "");
  EXPECT_EQ(there->cell->scene, "aprs_2024");
  EXPECT_EQ(there->epoch, 1u);
  // From then on it is the scene.
  EXPECT_EQ(command(api::SimulationCommand(api::Reset{}))->cell->scene, "aprs_2024");
  command(api::SimulationCommand(api::StepBy{300}));
  EXPECT_TRUE(eventually([&] { return simulation.latest()->step == 300; }));

  std::ifstream file(load_scene("aprs")->file);
  std::stringstream text;
  text << file.rdbuf();
  api::Reset sent;
  sent.scene_text = text.str();
  EXPECT_EQ(command(api::SimulationCommand(sent))->cell->scene, "sent");
  EXPECT_EQ(refused.message, "");
}

TEST_F(EditedSimulation, RefusesScenesThatItCannotHave) {
  const auto message = [&](const std::string& name, const std::string& text) {
    api::Reset reset;
    reset.scene_name = name;
    reset.scene_text = text;
    refused = {};
    EXPECT_EQ(command(api::SimulationCommand(reset))->cell->scene, "aprs");
    return refused.message;
  };
  EXPECT_NE(message("nothing", "").find("expected one of"), std::string::npos);
  EXPECT_NE(message("/etc/passwd", "").find("a file's path"), std::string::npos);
  EXPECT_NE(message("", "robots: 7").find("robots"), std::string::npos);
  EXPECT_EQ(simulation.latest()->epoch, 0u);
}

}  // namespace
}  // namespace aprsim::test
