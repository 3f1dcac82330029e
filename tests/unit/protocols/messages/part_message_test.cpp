#include <cmath>

#include <gtest/gtest.h>

#include "protocols/messages/write_message.hpp"
#include "world/api/description/cell_description.hpp"

// Parts and fixtures in the description of a cell.
namespace aprsim::protocols {
namespace {

TEST(PartMessage, EveryKindOfPieceIsWritten) {
  api::CellDescription cell;
  api::BodyDescription& body = cell.bodies.emplace_back();
  body.name = "pump";
  body.kind = api::BodyKind::kPart;
  body.material = "steel";
  body.box_max = {1, 2, 3};
  const Pose at{{0.1, 0.2, 0.3}, Eigen::Quaterniond::Identity()};
  body.pieces = {{api::BoxPiece{{1, 2, 3}}, at},
                 {api::ConePiece{0.1, 0.2, 0.3}, {}},
                 {api::CapsulePiece{0.4, 0.5}, {}},
                 {api::PrismPiece{{{0, 0}, {1, 0}, {0, 1}}, 0.6}, {}},
                 {api::HullPiece{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}}, {}}};
  cell.fixtures.push_back({"bin", at, {body.pieces[0]}});
  v1::CellDescription message;
  write_message(cell, message);
  ASSERT_EQ(message.bodies_size(), 1);
  EXPECT_EQ(message.bodies(0).kind(), v1::BODY_KIND_PART);
  ASSERT_TRUE(message.bodies(0).has_part());
  const v1::PartGeometry& part = message.bodies(0).part();
  EXPECT_EQ(part.material(), "steel");
  EXPECT_EQ(part.box_max_m().z(), 3);
  ASSERT_EQ(part.pieces_size(), 5);
  EXPECT_EQ(part.pieces(0).box().size_m().y(), 2);
  EXPECT_EQ(part.pieces(0).piece_in_body().position_m().z(), 0.3);
  EXPECT_EQ(part.pieces(1).cone().top_radius_m(), 0.2);
  EXPECT_EQ(part.pieces(2).capsule().length_m(), 0.5);
  EXPECT_EQ(part.pieces(3).prism().corners_m(1).x(), 1);
  EXPECT_EQ(part.pieces(3).prism().height_m(), 0.6);
  EXPECT_EQ(part.pieces(4).hull().corners_m_size(), 4);
  ASSERT_EQ(message.fixtures_size(), 1);
  EXPECT_EQ(message.fixtures(0).name(), "bin");
  EXPECT_EQ(message.fixtures(0).pieces(0).box().size_m().x(), 1);
}

TEST(PartMessage, ASlotHasThePocketsOutlineAndTurn) {
  api::CellDescription cell;
  api::BodyDescription& tray = cell.bodies.emplace_back();
  tray.kind = api::BodyKind::kKitTray;
  api::SlotDescription& slot = tray.slots.emplace_back();
  slot.X_PS.q = Eigen::AngleAxisd(1, Eigen::Vector3d::UnitZ());
  slot.pocket_depth_m = 0.02;
  slot.pocket_outline = {{0, 0}, {0.01, 0}, {0, 0.02}};
  tray.slots.emplace_back().pocket_depth_m = 0.01;
  v1::CellDescription message;
  write_message(cell, message);
  const v1::TrayGeometry& written = message.bodies(0).tray();
  ASSERT_EQ(written.slots_size(), 2);
  EXPECT_EQ(written.slots(0).pocket_depth_m(), 0.02);
  ASSERT_EQ(written.slots(0).pocket_outline_m_size(), 3);
  EXPECT_EQ(written.slots(0).pocket_outline_m(1).x(), 0.01);
  EXPECT_EQ(written.slots(0).pocket_outline_m(2).y(), 0.02);
  EXPECT_DOUBLE_EQ(written.slots(0).slot_in_tray().orientation().z(), std::sin(0.5));
  EXPECT_EQ(written.slots(1).pocket_outline_m_size(), 0);
}

}  // namespace
}  // namespace aprsim::protocols
