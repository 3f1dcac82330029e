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

}  // namespace
}  // namespace aprsim::protocols
