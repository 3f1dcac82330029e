#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/case_count.hpp"
#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"
#include "tests/unit/world/physics/random_part.hpp"
#include "world/physics/bodies/mass_properties.hpp"
#include "world/scene/checks/scene_solids.hpp"
#include "world/scene/model/pieces.hpp"
#include "world/scene/readers/pocket_reader.hpp"

// Pockets with an outline in the whole physics: parts of the same outline rest in them and cannot
// turn; nothing passes.
namespace aprsim::physics::test::outline_pockets {
namespace {

using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kThick = 0.03, kDepth = 0.012, kClearance = 1e-4;

Quaterniond turned(double angle, const Vector3d& axis) {
  return Quaterniond(Eigen::AngleAxisd(angle, axis));
}

api::Piece prism(std::vector<Vector2d> corners, double height_m) {
  return {api::PrismPiece{std::move(corners), height_m}, {}};
}

/// A part, its outline, and the pocket's, which is wider by the clearance on both sides together.
struct Fit {
  std::string name;
  std::vector<api::Piece> pieces;
  scene::Outline part, pocket;
  double half_height_m = 0;
};

Fit fit_of(std::string name, std::vector<Vector2d> corners, double height_m) {
  scene::Outline part = scene::outline_of(corners);
  const scene::Outline pocket = scene::widened(part, 0.5 * kClearance);
  return {std::move(name), {prism(std::move(corners), height_m)}, part, pocket, 0.5 * height_m};
}

/// A ring of six prisms around a hexagonal bore.
std::vector<api::Piece> nut_pieces(double bore_m, double radius_m, double height_m) {
  const auto inner = regular_polygon(6, bore_m), outer = regular_polygon(6, radius_m);
  std::vector<api::Piece> pieces;
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t k = (i + 1) % 6;
    pieces.push_back(prism({inner[i], outer[i], outer[k], inner[k]}, height_m));
  }
  return pieces;
}

std::vector<Vector2d> random_outline(std::mt19937_64& random) {
  std::uniform_real_distribution<double> shift(-0.3, 0.3);
  const int n = 3 + static_cast<int>(random() % 6);
  std::vector<Vector2d> corners;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (i + shift(random)) / n;
    corners.emplace_back(0.012 * std::cos(angle), 0.012 * std::sin(angle));
  }
  return corners;
}

std::vector<Fit> fits() {
  const std::vector<Vector2d> key{
      {0.004, 0.0035}, {-0.004, 0.0035}, {-0.004, -0.0035}, {0.004, -0.0035}};
  std::vector<Fit> out;
  out.push_back(fit_of("key", key, 0.05));
  out.back().pieces = {{api::BoxPiece{{0.008, 0.007, 0.05}}, {}}};
  out.push_back(fit_of("hexagon", regular_polygon(6, 0.0075), 0.02));
  out.push_back(fit_of("nut", regular_polygon(6, 0.0104), 0.0108));
  out.back().pieces = nut_pieces(0.00704, 0.0104, 0.0108);
  out.push_back(fit_of("rounded", scene::rectangle_outline({0.03, 0.018}, 0.004).corners, 0.02));
  return out;
}

/// The largest rotation about the middle with which the part's outline is in the pocket's.
double largest_turn(const Fit& fit) {
  double inside = 0, outside = 0.5;
  for (int i = 0; i < 40; ++i) {
    const double turn = 0.5 * (inside + outside);
    bool fits = true;
    for (const double sign : {-1.0, 1.0}) {
      for (const Vector2d& corner : scene::placed(fit.part, {0, 0}, sign * turn).corners) {
        fits = fits && fit.pocket.depth_of(corner) >= 0;
      }
    }
    (fits ? inside : outside) = turn;
  }
  return inside;
}

/// The largest distance between corners of the part and of the pocket where both have one middle.
double largest_shift(const Fit& fit) {
  double most = 0;
  for (std::size_t i = 0; i < fit.part.corners.size(); ++i) {
    most = std::max(most, (fit.pocket.corners[i] - fit.part.corners[i]).norm());
  }
  return most;
}

/// A tray with one pocket on a ramp that it does not slide on.
struct Tilted {
  double yaw = 0, slot_yaw = 0, tilt = 0, heading = 0, chamfer_m = 0;
  Vector2d slot_xy = Vector2d::Zero();

  explicit Tilted(std::mt19937_64& random) {
    std::uniform_real_distribution<double> turn(-3, 3), place(-0.015, 0.015), angle(0, 0.6);
    yaw = turn(random);
    slot_yaw = turn(random);
    heading = turn(random);
    tilt = random() % 3 == 0 ? 0 : angle(random);
    slot_xy.x() = place(random);
    slot_xy.y() = place(random);
    chamfer_m = random() % 2 == 0 ? 0 : 1e-3;
  }
  [[nodiscard]] Quaterniond slope() const {
    return turned(heading, Vector3d::UnitZ()) * turned(tilt, Vector3d::UnitY());
  }
  [[nodiscard]] Isometry3d X_WP() const {
    Isometry3d X(slope() * turned(yaw, Vector3d::UnitZ()));
    X.translation() = kThick * X.linear().col(2);
    return X;
  }
  [[nodiscard]] Isometry3d X_WS() const {
    return X_WP() * Eigen::Translation3d(slot_xy.x(), slot_xy.y(), 0) *
           turned(slot_yaw, Vector3d::UnitZ());
  }
  [[nodiscard]] scene::TrayType tray(const scene::Outline& outline) const {
    scene::TrayType type;
    type.name = "board";
    type.min_xy = {-0.05, -0.05};
    type.max_xy = {0.05, 0.05};
    type.thickness_m = kThick;
    type.mass_kg = 2;
    scene::Slot slot;
    slot.name = "slot";
    slot.xy = slot_xy;
    slot.yaw_rad = slot_yaw;
    slot.pocket.depth_m = kDepth;
    slot.pocket.chamfer_m = chamfer_m;
    slot.pocket.outline = outline;
    type.slots.push_back(slot);
    return type;
  }
  [[nodiscard]] scene::Scene scene(const scene::Outline& outline) const {
    scene::Scene scene = empty_scene();
    scene.physics.friction.tray_ground = 3;
    const double half = 0.1;
    Pose ramp;
    ramp.q = slope();
    ramp.p = -half * (slope() * Vector3d::UnitZ());
    scene.fixed.push_back({"ramp", {1, 1, 2 * half}, ramp});
    scene.tray_types["board"] = tray(outline);
    scene.trays.push_back({.name = "board", .type = "board", .X_WP = pose_of(X_WP())});
    return scene;
  }
  static Pose pose_of(const Isometry3d& X) {
    Pose pose;
    pose.p = X.translation();
    pose.q = Quaterniond(X.linear());
    return pose;
  }
};

/// Kinetic and potential energy of the tray and the part.
double energy_of(const Bench& bench, const MassProperties& tray, const MassProperties& part) {
  double energy = 0;
  for (const int i : {0, 1}) {
    const MassProperties& mass = i == 0 ? tray : part;
    const BodyState body = bench.world->body(i);
    const Vector3d arm = body.q_WB * mass.com, v = body.v_W + body.omega_W.cross(arm);
    const Vector3d omega_B = body.q_WB.conjugate() * body.omega_W;
    energy += 0.5 * (mass.mass_kg * v.squaredNorm() + omega_B.dot(mass.inertia * omega_B)) +
              mass.mass_kg * bench.scene.physics.gravity_m_s2 * (body.p_WB + arm).z();
  }
  return energy;
}

class OutlinePocket : public testing::TestWithParam<scene::Simplification> {};
INSTANTIATE_TEST_SUITE_P(Modes, OutlinePocket,
                         testing::Values(scene::Simplification::kOff,
                                         scene::Simplification::kVirtualJoints,
                                         scene::Simplification::kMerge,
                                         scene::Simplification::kDormant));

/// Height over the floor, shift and turn of the part in its slot.
struct Seat {
  double over_floor_m, shift_m, turn_rad, tilt_rad;
};

Seat seat_of(const Bench& bench, const Tilted& tilted, const Fit& fit) {
  const Isometry3d X_PS = tilted.X_WP().inverse() * tilted.X_WS();
  const Isometry3d X = (bench.X_WB("board") * X_PS).inverse() * bench.X_WB("part");
  const Vector3d bottom = X * Vector3d(0, 0, -fit.half_height_m);
  return {bottom.z() + kDepth, bottom.head<2>().norm(),
          std::abs(std::atan2(X.linear()(1, 0), X.linear()(0, 0))),
          std::acos(std::min(1.0, X.linear()(2, 2)))};
}

void expect_seated(const Bench& bench, const Tilted& tilted, const Fit& fit,
                   const std::string& what) {
  const Seat seat = seat_of(bench, tilted, fit);
  const double half_width = fit.part.corners[0].norm();
  EXPECT_NEAR(seat.over_floor_m, 0, 12e-6 + 1.2 * half_width * seat.tilt_rad) << what;
  EXPECT_LT(seat.shift_m, 1.3 * largest_shift(fit) + 2e-5) << what;
  EXPECT_LT(seat.turn_rad, 1.5 * largest_turn(fit) + 2e-3) << what;
  EXPECT_LT(seat.tilt_rad, 1.5 * kClearance / std::min(kDepth, 2 * fit.half_height_m) + 2e-3)
      << what;
}

/// The part, begun in the mouth of a level tray or 1 mm over the floor of a tilted one, where it
/// cannot wedge, falls to the floor, and is then struck along the tray and spun.
void drop_and_strike(const Fit& fit, const Tilted& tilted, scene::Simplification mode,
                     std::mt19937_64& random, const std::string& what) {
  std::uniform_real_distribution<double> share(-1, 1);
  scene::Scene scene = tilted.scene(fit.pocket);
  scene.physics.simplification = mode;
  const scene::PartType type = part_type("part", fit.pieces, 0.02);
  scene.physics.friction.gear_tray = 0.1;
  const double bottom = tilted.tilt == 0 ? -tilted.chamfer_m - 5e-4 : 1e-3 - kDepth;
  const Isometry3d start = tilted.X_WS() * Eigen::Translation3d(0, 0, fit.half_height_m + bottom);
  add_part(scene, "part", type, Tilted::pose_of(start));
  const MassProperties tray = tray_mass(scene.tray_types.at("board"));
  const MassProperties part{type.mass_kg, type.com, type.inertia};
  Bench bench(std::move(scene));
  const int index = bench.index_of("part");
  double energy = energy_of(bench, tray, part), rise = 0;
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      bench.run(1);
      const double now = energy_of(bench, tray, part);
      rise = std::max(rise, now - energy);
      energy = now;
      for (const api::Piece& piece : fit.pieces) {
        ASSERT_TRUE(scene::lies_in_pocket(piece, Tilted::pose_of(bench.X_WB("part")),
                                          bench.scene.tray_types.at("board"),
                                          Tilted::pose_of(bench.X_WB("board"))))
            << what << " at " << bench.steps;
      }
    }
  };
  run(400);
  expect_seated(bench, tilted, fit, what + " at rest");
  for (int blow = 0; blow < 3; ++blow) {
    const Eigen::Matrix3d R = bench.X_WB("board").linear();
    bench.world->set_velocity(index, R * Vector3d(0.3 * share(random), 0.3 * share(random), 0),
                              R * Vector3d(0, 0, 20 * share(random)));
    energy = energy_of(bench, tray, part);
    run(250);
    expect_seated(bench, tilted, fit, what + " after a blow");
  }
  EXPECT_TRUE(bench.world->body(index).resting) << what;
  // As much as to lift the part by one micrometre out of a penetration.
  EXPECT_LT(rise, 1e-6 * type.mass_kg * bench.scene.physics.gravity_m_s2) << what;
  EXPECT_EQ(bench.world->penetration_faults(), 0u) << what;
}

TEST_P(OutlinePocket, HoldsPartsOfItsShape) {
  std::mt19937_64 random(48);
  for (const Fit& fit : fits()) {
    for (int i = 0; i < 3; ++i) {
      const Tilted tilted(random);
      drop_and_strike(fit, tilted, GetParam(), random, fit.name + std::to_string(i));
    }
  }
}

TEST_P(OutlinePocket, HoldsRandomPolygons) {
  std::mt19937_64 random(49);
  for (int i = 0; i < 6; ++i) {
    const Fit fit = fit_of("polygon", random_outline(random), 0.02);
    const Tilted tilted(random);
    drop_and_strike(fit, tilted, GetParam(), random, fit.name + std::to_string(i));
  }
}

/// A level tray with one pocket on a table.
scene::Scene level_scene(const scene::Outline& outline, double chamfer_m, double yaw_rad) {
  std::mt19937_64 random(1);
  Tilted level(random);
  level.tilt = level.heading = 0;
  level.yaw = yaw_rad;
  level.slot_xy.setZero();
  level.chamfer_m = chamfer_m;
  scene::Scene scene = level.scene(outline);
  scene.tray_types["board"].slots[0].yaw_rad = 0.3;
  return scene;
}

// Round parts rest on the floor of a square pocket, also where they lie or lean on its walls.
TEST_P(OutlinePocket, HoldsRoundParts) {
  const double r = 0.01, half = r + 0.5 * kClearance;
  const auto square =
      scene::outline_of({{-half, -half}, {half, -half}, {half, half}, {-half, half}});
  struct Round {
    const char* name;
    api::Piece piece;
    double height_m;  // of the frame over the floor
    Quaterniond q = Quaterniond::Identity();
  };
  const Quaterniond lying = turned(std::numbers::pi / 2, Vector3d::UnitY());
  const std::vector<Round> parts = {
      {"cylinder", {api::ConePiece{r, r, 0.04}, {}}, 0.02},
      {"cone", {api::ConePiece{r, 0.004, 0.03}, {}}, 0.015},
      {"ball", {api::CapsulePiece{r, 0}, {}}, r},
      {"lying capsule", {api::CapsulePiece{0.004, 0.01}, {}}, 0.004, lying},
      {"lying cylinder", {api::ConePiece{0.006, 0.006, 0.014}, {}}, 0.006, lying}};
  for (const Round& round : parts) {
    for (const double chamfer : {0.0, 1e-3}) {
      scene::Scene scene = level_scene(square, chamfer, 0.8);
      scene.physics.simplification = GetParam();
      scene.physics.rolling_m.gear_tray = 5e-4;
      Pose pose;
      pose.p = {0, 0, kThick - kDepth + round.height_m + 2e-3};
      pose.q = turned(1.1, Vector3d::UnitZ()) * round.q;
      add_part(scene, "part", part_type("part", {round.piece}, 0.05), pose);
      Bench bench(std::move(scene));
      const int index = bench.index_of("part");
      for (int step = 0; step < 900; ++step) {
        if (step == 400) bench.world->set_velocity(index, {0.2, 0.1, 0}, {0, 0, 5});
        bench.run(1);
        ASSERT_TRUE(scene::lies_in_pocket(round.piece, Tilted::pose_of(bench.X_WB("part")),
                                          bench.scene.tray_types.at("board"),
                                          Tilted::pose_of(bench.X_WB("board"))))
            << round.name << " at " << step;
      }
      EXPECT_NEAR(bench.X_WB("part").translation().z(), kThick - kDepth + round.height_m, 6e-5)
          << round.name;
      EXPECT_LT(bench.world->body(index).v_W.norm(), 1e-3) << round.name;
      EXPECT_EQ(bench.world->penetration_faults(), 0u) << round.name;
    }
  }
}

TEST_P(OutlinePocket, HoldsAGearByItsDisc) {
  scene::Scene scene = level_scene(scene::rectangle_outline({0.04, 0.04}, 0.006), 0, 0.2);
  scene.physics.simplification = GetParam();
  const scene::GearType& gear = scene.gear_types.at("medium");
  const double side = 2 * (gear.hub_top_radius_m + kClearance);
  scene.tray_types["board"].slots[0].pocket.outline =
      scene::rectangle_outline({side, side}, 0.2 * side);
  scene.tray_types["board"].slots[0].pocket.depth_m = gear.hub_height_m + 1e-3;
  Pose pose;
  pose.p = {2e-5, 0, kThick + 2e-3};
  add_gear(scene, "gear", "medium", pose);
  Bench bench(std::move(scene));
  bench.run(400);
  bench.world->set_velocity(bench.index_of("gear"), {0.1, 0.05, 0}, {0, 0, 3});
  bench.run(600);
  const Vector3d p = bench.X_WB("gear").translation() - bench.X_WB("board").translation();
  EXPECT_NEAR(p.z(), 0, 12e-6);
  EXPECT_LT(p.head<2>().norm(), 2 * kClearance);
  EXPECT_TRUE(bench.world->body(bench.index_of("gear")).resting);
  EXPECT_EQ(bench.world->penetration_faults(), 0u);
}

// A plate slides over a pocket's mouth, and over the corners of it, as over a plain board.
TEST(OutlinePocketSlide, TheMouthCatchesNothing) {
  for (const double yaw : {0.0, 0.4, 1.3}) {
    scene::Scene scene = level_scene(scene::rectangle_outline({0.02, 0.03}, 0.004), 0, yaw);
    scene.physics.simplification = scene::Simplification::kOff;
    scene::TrayType& board = scene.tray_types["board"];
    board.min_xy = {-0.3, -0.1};
    board.max_xy = {0.3, 0.1};
    board.mass_kg = 40;
    board.slots.push_back(board.slots[0]);
    board.slots[1].name = "second";
    board.slots[1].xy = {0.045, 0.01};
    board.slots[1].pocket.outline = scene::outline_of(regular_polygon(5, 0.012));
    const Vector3d along = turned(yaw, Vector3d::UnitZ()) * Vector3d::UnitX();
    Pose pose;
    pose.p = -0.15 * along;
    pose.p.z() = kThick + 0.005;
    pose.q = turned(yaw + 0.3, Vector3d::UnitZ());
    add_part(scene, "plate", part_type("plate", {{api::BoxPiece{{0.06, 0.05, 0.01}}, {}}}, 0.1),
             pose);
    Bench bench(std::move(scene));
    bench.run(200);
    const Vector3d start = bench.X_WB("plate").translation();
    const double v = 1.2, mu = bench.scene.physics.friction.gear_tray;
    bench.world->set_velocity(bench.index_of("plate"), v * along, Vector3d::Zero());
    bench.run(800);
    const Vector3d way = bench.X_WB("plate").translation() - start;
    const double far = v * v / (2 * mu * bench.scene.physics.gravity_m_s2);
    EXPECT_NEAR(way.dot(along), far, 0.02 * far) << yaw;
    EXPECT_NEAR(way.z(), 0, 2e-5) << yaw;
  }
}

// Parts of every kind at up to 8 m/s at a board with pockets. A corner that strikes a wall and the
// floor at once may be deep for a step.
TEST(OutlinePocketThrow, NothingPasses) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> share(-1, 1);
  std::normal_distribution<double> normal;
  const int cases = aprsim::test::case_count(56);
  std::uint64_t faults = 0;
  for (int i = 0; i < cases; ++i) {
    scene::Scene scene = level_scene(i % 3 == 0 ? scene::outline_of(regular_polygon(6, 0.025))
                                                : scene::rectangle_outline({0.05, 0.03}, 0.005),
                                     i % 2 == 0 ? 0 : 2e-3, share(random));
    scene.tray_types["board"].mass_kg = 20;
    const api::Piece piece = random_piece(static_cast<PieceShape>(i % kPieceShapes), 0.012, random);
    Pose above;
    above.p = {0.02 * share(random), 0.02 * share(random), 0.15};
    const double w = normal(random), x = normal(random), y = normal(random);
    above.q = Quaterniond(w, x, y, normal(random)).normalized();
    add_part(scene, "part", part_type("any", {piece}, 0.05), above);
    Bench bench(std::move(scene));
    const int index = bench.index_of("part");
    bench.world->set_velocity(index, {share(random), share(random), -8},
                              10 * Vector3d(share(random), share(random), share(random)));
    for (int step = 0; step < 400; ++step) {
      bench.run(1);
      const Isometry3d X = bench.X_WB("board").inverse() * bench.X_WB("part");
      if (X.translation().head<2>().cwiseAbs().maxCoeff() > 0.04) break;
      const Vector3d down = X.linear().transpose() * -Vector3d::UnitZ();
      ASSERT_GT((X * scene::support_of(piece, down)).z(), -kDepth - 0.5e-3)
          << name_of(static_cast<PieceShape>(i % kPieceShapes)) << i << " at " << step;
    }
    faults += bench.world->penetration_faults();
  }
  EXPECT_LE(faults, 2u);
}

}  // namespace
}  // namespace aprsim::physics::test::outline_pockets
