#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "tests/support/holding_gap.hpp"
#include "tests/unit/world/scene/scene_fixture.hpp"
#include "world/scene/checks/scene_solids.hpp"

namespace aprsim::scene {
namespace {

Scene shipped(const std::string& name) {
  auto scene = load_scene(name, default_data_paths());
  EXPECT_TRUE(scene.has_value()) << scene.error().message;
  return scene ? std::move(*scene) : Scene{};
}

class ShippedScene : public testing::TestWithParam<std::string> {};

TEST_P(ShippedScene, Loads) {
  const Scene scene = shipped(GetParam());
  EXPECT_EQ(scene.name, GetParam());
  EXPECT_EQ(scene.file, APRSIM_SOURCE_DIR "/world/scenes/" + GetParam() + ".yaml");
}

TEST_P(ShippedScene, SeatedGearsHaveTheirSlotsPoses) {
  const Scene scene = shipped(GetParam());
  std::size_t seated = 0;
  for (const TrayInstance& tray : scene.trays) {
    const TrayType& type = scene.tray_types.at(tray.type);
    for (const auto& [slot_name, gear_name] : tray.gears) {
      const auto slot = std::find_if(type.slots.begin(), type.slots.end(),
                                     [&name = slot_name](const Slot& s) { return s.name == name; });
      ASSERT_NE(slot, type.slots.end());
      const Eigen::Vector3d p_WS =
          tray.X_WP.isometry() * Eigen::Vector3d(slot->xy.x(), slot->xy.y(), 0);
      const Eigen::Quaterniond q_WS =
          tray.X_WP.q * Eigen::AngleAxisd(slot->yaw_rad, Eigen::Vector3d::UnitZ());
      const auto expect_seated = [&](const auto& bodies) {
        for (const auto& body : bodies) {
          if (body.name != gear_name) continue;
          EXPECT_EQ(body.type, slot->gear_type);
          EXPECT_LT((body.X_WP.p - p_WS).norm(), 1e-12);
          EXPECT_LT(body.X_WP.q.angularDistance(q_WS), 1e-12);
          ++seated;
        }
      };
      expect_seated(scene.gears);
      expect_seated(scene.parts);
    }
  }
  std::size_t given = 0;
  for (const TrayInstance& tray : scene.trays) given += tray.gears.size();
  EXPECT_EQ(seated, given);
  // Gears are in trays, or loose where there are none.
  EXPECT_GE(seated, scene.trays.empty() ? 0 : scene.gears.size());
}

TEST_P(ShippedScene, NeighbouringGearsHaveRoom) {
  // Every slot of every tray filled: discs at least 1.5 mm apart, pegs clear of everything.
  const Scene scene = shipped(GetParam());
  for (const auto& [name, type] : scene.tray_types) {
    for (std::size_t i = 0; i < type.slots.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Slot &a = type.slots[i], &b = type.slots[j];
        if (!scene.gear_types.contains(a.gear_type) || !scene.gear_types.contains(b.gear_type))
          continue;
        const double gap = (a.xy - b.xy).norm() - scene.gear_types.at(a.gear_type).disc_radius_m -
                           scene.gear_types.at(b.gear_type).disc_radius_m;
        EXPECT_GE(gap, 1.5e-3) << name << ": " << a.name << ", " << b.name;
      }
    }
  }
}

TEST_P(ShippedScene, HubsCentreThemselvesWithTheSameClearanceAllTheWayDown) {
  const Scene scene = shipped(GetParam());
  for (const auto& [name, type] : scene.tray_types) {
    for (const Slot& slot : type.slots) {
      if (!scene.gear_types.contains(slot.gear_type)) continue;  // of a part
      const GearType& gear = scene.gear_types.at(slot.gear_type);
      const double slope =
          (slot.pocket.top_radius_m - slot.pocket.floor_radius_m) / slot.pocket.depth_m;
      EXPECT_NEAR(slot.pocket.top_radius_m - gear.hub_top_radius_m, 2e-4, 1e-6) << name;
      const double wall = slot.pocket.top_radius_m - slope * gear.hub_height_m;
      EXPECT_NEAR(wall - gear.hub_bottom_radius_m, 2e-4, 3e-5) << name;
      EXPECT_NEAR(std::atan(slope), std::numbers::pi / 6, 2e-3) << name;
    }
  }
}

TEST_P(ShippedScene, RestsOnWhatItStandsOn) {
  // Each tray's underside touches the top of a fixed box or of the belt.
  const Scene scene = shipped(GetParam());
  for (const TrayInstance& tray : scene.trays) {
    const double underside = tray.X_WP.p.z() - scene.tray_types.at(tray.type).thickness_m;
    bool carried = scene.conveyor && std::abs(underside - scene.conveyor->X_WC.p.z()) < 1e-12;
    for (const StaticBox& box : scene.fixed) {
      carried = carried || std::abs(underside - box.X_WS.p.z() - box.size.z() / 2) < 1e-12;
    }
    EXPECT_TRUE(carried) << tray.name;
  }
}

TEST_P(ShippedScene, GripperTakesAPegWithRoomAround) {
  // At the pick height, 3.5 mm above the disc, on any gear and with open fingers.
  const Scene scene = shipped(GetParam());
  for (const Robot& robot : scene.robots) {
    const Gripper& g = robot.gripper;
    for (const auto& [name, gear] : scene.gear_types) {
      const double tip = gear.disc_height_m + 3.5e-3;
      EXPECT_GT(gear.peg_top_m - tip, 0.01) << "the pads hold the peg over 10 mm";
      EXPECT_LT(gear.peg_top_m, tip + g.pad_height_m) << "the palm is clear of the peg";
      const physics::Pad pad{g.pad,         g.pad_height_m,     g.pad_width_m,
                             g.pad_depth_m, g.v_half_angle_rad, g.v_depth_m};
      EXPECT_GT(physics::holding_gap(pad, gear.peg_radius_m), g.gap_closed_m + 1e-4)
          << "both closing fingers have 0.05 mm left when they hold the peg";
      EXPECT_LT(2 * gear.peg_radius_m + 2e-3, g.gap_open_m) << "open fingers pass the peg";
    }
    for (const auto& [name, type] : scene.tray_types) {
      const double reach = std::hypot(g.gap_open_m / 2 + g.pad_depth_m, g.pad_width_m / 2);
      for (std::size_t i = 0; i < type.slots.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
          const double pitch = (type.slots[i].xy - type.slots[j].xy).norm();
          EXPECT_GT(pitch - 4e-3, reach) << robot.name << " fingers on the next peg of " << name;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScene, testing::ValuesIn(scene_names(default_data_paths())),
                         [](const auto& test) { return test.param; });

TEST(ShippedAprs, HasTheCellsParts) {
  const Scene scene = shipped("aprs");
  ASSERT_EQ(scene.robots.size(), 2u);
  EXPECT_EQ(scene.robots[0].name, "fanuc");
  EXPECT_EQ(scene.robots[1].name, "motoman");
  EXPECT_EQ(scene.robots[0].home_rad.size(), 6u);
  EXPECT_EQ(scene.robots[1].home_rad.size(), 7u);
  ASSERT_TRUE(scene.conveyor);
  EXPECT_NEAR(scene.conveyor->max_speed_m_s, 0.32768, 1e-12);
  std::multiset<std::string> types;
  for (const TrayInstance& tray : scene.trays) types.insert(tray.type);
  EXPECT_EQ(types.count("sku_kit_m2l1_vessel"), 2u);
  EXPECT_EQ(types.count("sku_kit_s2l2_vessel"), 2u);
  for (const char* kind : {"small", "medium", "large"}) {
    EXPECT_GE(types.count(std::string("sku_") + kind + "_gear_vessel"), 1u);
    EXPECT_TRUE(scene.gear_types.contains(std::string("sku_part_") + kind + "_gear"));
  }
}

TEST(ShippedAprs, HasGearsForEveryKit) {
  for (const char* name : {"aprs", "aprs_2024", "aprs_lab"}) {
    const Scene scene = shipped(name);
    std::map<std::string, int> there, wanted;
    for (const GearInstance& gear : scene.gears) ++there[gear.type];
    for (const TrayInstance& tray : scene.trays) {
      const TrayType& type = scene.tray_types.at(tray.type);
      if (type.kind != api::BodyKind::kKitTray) continue;
      for (const Slot& slot : type.slots) ++wanted[slot.gear_type];
    }
    for (const auto& [type, count] : wanted) EXPECT_GE(there[type], count) << name << ' ' << type;
  }
}

TEST(ShippedAprs, ToolFramePointsAlongTheApproach) {
  const Scene scene = shipped("aprs");
  // Fanuc: the flange's x; Motoman: its z. The fingers move along y in both.
  const Eigen::Matrix3d fanuc = scene.robots[0].X_FT.isometry().linear();
  EXPECT_LT((fanuc.col(2) - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((fanuc.col(1) - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((scene.robots[0].X_FT.p - Eigen::Vector3d(0.194, 0, 0)).norm(), 1e-12);
  EXPECT_LT((scene.robots[1].X_FT.p - Eigen::Vector3d(0, 0, 0.30187)).norm(), 1e-12);
  EXPECT_LT(scene.robots[1].X_FT.q.angularDistance(Eigen::Quaterniond::Identity()), 1e-12);
}

TEST(ShippedAprs, BeltCanCarryTheUpstreamTrayInWithoutLosingTheOthers) {
  for (const char* name : {"aprs", "aprs_2024"}) {
    const Scene scene = shipped(name);
    const double end = scene.conveyor->X_WC.p.x() + scene.conveyor->length_m / 2;
    double first = 0, last = 0;
    for (const TrayInstance& tray : scene.trays) {
      if (std::abs(tray.X_WP.p.y() - scene.conveyor->X_WC.p.y()) > scene.conveyor->width_m / 2) {
        continue;
      }
      const Solid solid = solid_of(scene.tray_types.at(tray.type), tray.X_WP);
      first = std::min(first, tray.X_WP.p.x());
      last = std::max(last, solid.support(Eigen::Vector3d::UnitX()).x());
    }
    EXPECT_LT(first, -0.95) << name << ": a tray upstream of the robots";
    EXPECT_LT(last + 0.8, end) << name << ": room for the others to be carried along";
  }
}

TEST(ShippedLab, RobotsSpeakTheLaboratorysConventions) {
  const Scene scene = shipped("aprs_lab");
  ASSERT_EQ(scene.robots.size(), 2u);
  const Robot &fanuc = scene.robots[0], &motoman = scene.robots[1];
  ASSERT_EQ(fanuc.crcl_joints.size(), 6u);
  const api::WireJoint& third = fanuc.crcl_joints[2];
  EXPECT_EQ(third.joint, 2);
  EXPECT_EQ(third.counts_per_rad, 0);
  ASSERT_EQ(third.couplings.size(), 1u);
  EXPECT_EQ(third.couplings[0].joint, 1);
  EXPECT_EQ(third.couplings[0].factor, 1);
  EXPECT_NEAR(third.range.upper_rad, 280 * std::numbers::pi / 180, 1e-12);
  EXPECT_FALSE(fanuc.crcl_joints[1].has_range());
  ASSERT_TRUE(fanuc.tool_point_F);
  EXPECT_EQ(fanuc.tool_point_F->p, Eigen::Vector3d::Zero());
  EXPECT_EQ(fanuc.X_BR.p, Eigen::Vector3d(0, 0, 0.33));
  EXPECT_EQ(fanuc.gripper_names, std::vector<std::string>{"SCHUNK_MPG40"});
  EXPECT_TRUE(fanuc.clamps_targets) << "as NIST's server of it";
  EXPECT_FALSE(motoman.clamps_targets) << "its controller refuses";
  ASSERT_EQ(motoman.crcl_joints.size(), 8u);
  EXPECT_EQ(motoman.crcl_joints[2].joint, 3);
  EXPECT_EQ(motoman.crcl_joints[6].joint, 2);
  EXPECT_EQ(motoman.crcl_joints[7].joint, -1);
  EXPECT_NEAR(motoman.crcl_joints[3].counts_per_rad, 1149.15 * 180 / std::numbers::pi, 1e-9);
  ASSERT_TRUE(motoman.tool_point_F);
  EXPECT_EQ(motoman.tool_point_F->p, Eigen::Vector3d(0, 0, 0.2075));
  // The others keep to the model.
  for (const Robot& robot : shipped("aprs").robots) {
    EXPECT_TRUE(robot.crcl_joints.empty() && robot.gripper_names.empty() && !robot.tool_point_F);
  }
}

TEST(ShippedLab, ToolsOnRobotsAndInHolders) {
  const Scene scene = shipped("aprs_lab");
  ASSERT_EQ(scene.tools.size(), 3u);
  EXPECT_EQ(scene.robots[0].tool, "pincher");
  EXPECT_EQ(scene.robots[1].tool, "big_gripper");
  EXPECT_EQ(tools_at_start(scene), (std::vector<int>{0, 1}));
  EXPECT_EQ(tools_of(scene).size(), 3u);
  const Tool& cup = scene.tools[2];
  ASSERT_TRUE(cup.gripper.cup);
  EXPECT_NEAR(cup.gripper.cup->max_vacuum_pa, 60e3, 1e-6);
  EXPECT_NEAR(cup.gripper.cup->free_flow_m3_s, 10e-3 / 60, 1e-9);
  EXPECT_GT(cup.X_WQ.p.z(), 1);
  // The tools are where the robots' types have their grippers.
  for (std::size_t r = 0; r < 2; ++r) {
    const Robot& lab = scene.robots[r];
    const Robot robot = shipped("aprs").robots[r];
    EXPECT_LT((lab.X_FT.p - robot.X_FT.p).norm(), 1e-9);
    EXPECT_LT(lab.X_FT.q.angularDistance(robot.X_FT.q), 1e-6);
    EXPECT_EQ(lab.gripper.stroke_m, robot.gripper.stroke_m);
  }
  // The scenes without tools of their own have the grippers of their robots' types.
  const Scene plain = shipped("aprs");
  const std::vector<Tool> own = tools_of(plain);
  ASSERT_EQ(own.size(), 2u);
  EXPECT_EQ(own[1].name, "motoman_gripper");
  EXPECT_TRUE(own[1].own);
  const Eigen::Isometry3d X_FT = coupling_of(plain.robots[1]).isometry() * own[1].X_QT.isometry();
  EXPECT_TRUE(X_FT.isApprox(plain.robots[1].X_FT.isometry(), 1e-12));
}

TEST(ShippedOnly, OneArmAtTheOriginAndNothingToHit) {
  for (const char* name : {"fanuc_only", "motoman_only"}) {
    const Scene scene = shipped(name);
    ASSERT_EQ(scene.robots.size(), 1u) << name;
    EXPECT_EQ(scene.robots[0].X_WB.p, Eigen::Vector3d::Zero());
    EXPECT_FALSE(scene.robots[0].self_collision);
    EXPECT_FALSE(scene.floor);
    EXPECT_FALSE(scene.conveyor);
    EXPECT_TRUE(scene.fixed.empty() && scene.trays.empty() && scene.gears.empty());
    EXPECT_GT(scene.robots[0].gripper.stroke_m, 0);
  }
}

TEST(ShippedTable1, TenTraysFortyGears) {
  const Scene scene = shipped("table1");
  EXPECT_EQ(scene.trays.size(), 10u);
  EXPECT_EQ(scene.gears.size(), 40u);
  for (const TrayInstance& tray : scene.trays) EXPECT_EQ(tray.gears.size(), 4u);
  EXPECT_TRUE(scene.conveyor);
}

TEST(ShippedBelt, OneEmptyTray) {
  const Scene scene = shipped("empty_belt");
  EXPECT_TRUE(scene.robots.empty());
  EXPECT_EQ(scene.trays.size(), 1u);
  EXPECT_TRUE(scene.gears.empty());
}

class SmallScene : public SceneFiles {};

TEST_F(SmallScene, SimplificationIsOneOfFourAndDormantByDefault) {
  write("arm.urdf", "<robot/>");
  const auto read = [&](const std::string& line) {
    const auto scene =
        load(write("scene.yaml", replaced(small_scene(), "  simplification: off\n", line)));
    EXPECT_TRUE(scene.has_value()) << scene.error().message;
    return scene->physics.simplification;
  };
  EXPECT_EQ(read("  simplification: virtual_joints\n"), Simplification::kVirtualJoints);
  EXPECT_EQ(read("  simplification: merge\n"), Simplification::kMerge);
  EXPECT_EQ(read("  simplification: dormant\n"), Simplification::kDormant);
  EXPECT_EQ(read(""), Simplification::kDormant);
}

TEST_F(SmallScene, TheEngineIsRead) {
  const auto read = [this](const std::string& keys) {
    std::string text = small_scene();
    const std::string at = "  step_s: 0.001\n";
    text.insert(text.find(at) + at.size(), keys);
    write("arm.urdf", "<robot/>");
    const auto scene = load(write("scene.yaml", text));
    EXPECT_TRUE(scene.has_value()) << scene.error().message;
    return scene->physics;
  };
  EXPECT_EQ(read("").engine, PhysicsEngine::kAprsim);
  const Physics usual = read("  engine: ode\n");
  EXPECT_EQ(usual.engine, PhysicsEngine::kOde);
  EXPECT_EQ(usual.ode.stepper, OdeSettings::Stepper::kQuick);
  EXPECT_EQ(usual.ode.iterations, 200);
  const Physics set =
      read("  engine: ode\n  ode: {stepper: direct, iterations: 20, erp: 0.4, cfm: 1e-5}\n");
  EXPECT_EQ(set.ode.stepper, OdeSettings::Stepper::kDirect);
  EXPECT_EQ(set.ode.iterations, 20);
  EXPECT_EQ(set.ode.erp, 0.4);
  EXPECT_EQ(set.ode.cfm_m_s_n, 1e-5);
}

TEST_F(SmallScene, EverythingIsRead) {
  write("arm.urdf", "<robot/>");
  const auto scene = load(write("scene.yaml", small_scene()));
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  EXPECT_EQ(scene->seed, 7u);
  EXPECT_EQ(scene->physics.restitution.gear_ground, 0.3);
  EXPECT_EQ(scene->physics.restitution.gear_tray, 0);
  EXPECT_NEAR(scene->physics.rolling_m.gear_ground, 1e-4, 1e-16);
  EXPECT_NEAR(scene->physics.spinning_m.tray_ground, 2e-3, 1e-15);
  EXPECT_EQ(scene->physics.simplification, Simplification::kOff);
  EXPECT_EQ(scene->physics.friction.gear_tray, 0.4);
  EXPECT_EQ(scene->physics.friction.tray_belt, kUsualFriction.tray_belt);
  const Robot& robot = scene->robots.at(0);
  EXPECT_EQ(robot.name, "robbie");
  EXPECT_EQ(robot.model_file, directory_ + "/arm.urdf");
  EXPECT_NEAR(robot.home_rad.at(4), -std::numbers::pi / 2, 1e-15);
  EXPECT_LT((robot.X_WB.q * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  const TrayInstance& tray = scene->trays.at(0);
  EXPECT_NEAR(tray.X_WP.p.z(), 0.917, 1e-12);
  EXPECT_EQ(tray.reachable_by, std::vector<std::string>{"robbie"});
  EXPECT_LT((scene->gears.at(0).X_WP.p - Eigen::Vector3d(0.2, 0.97, 0.917)).norm(), 1e-12);
  EXPECT_EQ(scene->gears.at(1).name, "wheel_2");
  EXPECT_NEAR(scene->gear_types.at("wheel").peg_top_m, 0.0225, 1e-15);
}

}  // namespace
}  // namespace aprsim::scene
