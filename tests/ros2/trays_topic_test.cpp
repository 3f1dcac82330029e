// Trays that aprsim-ros2 publishes as NIST's aprs_vision does, read by Fast DDS beside the real
// daemon.

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/ros2/ros2_fixture.hpp"
#include "tests/support/cell_client.hpp"

namespace aprsim::test {
namespace {

const std::string kTrays = "aprs_interfaces::msg::dds_::Trays_";
const std::string kTable = "rt/fanuc/table_trays_info";

struct ReadTray {
  int identifier = 0;
  bool is_kit = false;
  std::string frame;
  std::array<double, 7> pose{};
  std::map<std::string, int> sizes;
  std::set<std::string> occupied;
};
using ReadTrays = std::map<std::string, ReadTray>;

std::array<double, 7> read_pose(CdrReader& in, std::string& frame) {
  in.time();
  frame = in.text();
  std::array<double, 7> pose{};
  for (auto& value : pose) value = in.number<double>();
  return pose;
}

ReadTrays read_trays(const std::vector<unsigned char>& sample) {
  CdrReader in(sample);
  ReadTrays trays;
  for (const bool is_kit : {true, false}) {
    const auto count = in.number<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) {
      const int identifier = in.number<std::uint8_t>();
      const std::string name = in.text();
      ReadTray& tray = trays[name];
      tray.identifier = identifier;
      tray.is_kit = is_kit;
      tray.pose = read_pose(in, tray.frame);
      const auto slots = in.number<std::uint32_t>();
      for (std::uint32_t slot = 0; slot < slots; ++slot) {
        const bool occupied = in.number<std::uint8_t>() != 0;
        const int size = in.number<std::uint8_t>();
        const std::string slot_name = in.text();
        tray.sizes[slot_name] = size;
        if (occupied) tray.occupied.insert(slot_name);
        std::string frame;
        EXPECT_DOUBLE_EQ(read_pose(in, frame)[2], 0.016);
        EXPECT_EQ(frame, name);
      }
    }
  }
  EXPECT_TRUE(in.at_end());
  return trays;
}

/// The laboratory of 2025, whose cameras have the names of aprs_vision.
class Ros2TrayTopics : public Ros2 {
 protected:
  Ros2TrayTopics() : Ros2({"--scene", "aprs_2025"}), cell_(daemon_->port("grpc")) {}

  /// The trays of a topic once they meet a condition.
  ReadTrays trays(const std::string& topic, const std::function<bool(const ReadTrays&)>& met) {
    ReadTrays read;
    EXPECT_TRUE(take_until(topic, [&](const auto& sample) {
      read = read_trays(sample);
      return met(read);
    })) << topic;
    return read;
  }

  CellClient cell_;
};

using Names = std::set<std::string>;

TEST_F(Ros2TrayTopics, TraysAndSlotsAreAsInTheScene) {
  fast_dds_->subscribe(kTable, kTrays, false);
  fast_dds_->subscribe("rt/teach/table_trays_info", kTrays, false);
  auto seen = trays(kTable, [](const auto& read) { return !read.empty(); });
  ASSERT_EQ(seen.size(), 4U);
  EXPECT_EQ(seen["m2l1_kit_tray_02"].identifier, 16);
  EXPECT_TRUE(seen["m2l1_kit_tray_02"].is_kit);
  EXPECT_EQ(seen["m2l1_kit_tray_02"].occupied,
            (Names{"m2l1_kit_tray_02_lg_1", "m2l1_kit_tray_02_mg_1", "m2l1_kit_tray_02_mg_2"}));
  EXPECT_EQ(seen["m2l1_kit_tray_02"].sizes["m2l1_kit_tray_02_lg_1"], 3);
  EXPECT_EQ(seen["m2l1_kit_tray_02"].sizes["m2l1_kit_tray_02_mg_2"], 2);
  EXPECT_EQ(seen["m2l1_kit_tray_05"].occupied, Names{});
  EXPECT_EQ(seen["medium_gear_tray_03"].identifier, 14);
  EXPECT_FALSE(seen["medium_gear_tray_03"].is_kit);
  EXPECT_EQ(seen["medium_gear_tray_03"].occupied,
            (Names{"medium_gear_tray_03_slot_3", "medium_gear_tray_03_slot_4"}));
  EXPECT_EQ(seen["large_gear_tray_04"].identifier, 15);
  EXPECT_EQ(seen["large_gear_tray_04"].occupied, Names{"large_gear_tray_04_slot_2"});
  const auto snapshot = cell_.snapshot();
  const auto body = std::ranges::find_if(snapshot.bodies(),
                                         [](const auto& one) { return one.name() == "medium_03"; });
  ASSERT_NE(body, snapshot.bodies().end());
  const auto& p = body->body_in_world().position_m();
  const auto& q = body->body_in_world().orientation();
  EXPECT_EQ(seen["medium_gear_tray_03"].pose,
            (std::array<double, 7>{p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}));
  EXPECT_EQ(seen["medium_gear_tray_03"].frame, "world");
  const auto taught =
      trays("rt/teach/table_trays_info", [](const auto& read) { return !read.empty(); });
  EXPECT_EQ(taught.size(), 2U);
  EXPECT_TRUE(taught.contains("s2l2_kit_tray_05"));
  const auto writer = fast_dds_->writers().at(kTable);
  EXPECT_TRUE(writer.reliable);
  EXPECT_EQ(writer.user_data,
            "typehash=RIHS01_16983bf374c85b25c949641615b1d1f3c68bf216bc0fa06e7c44f5551842b4bf;");
}

TEST_F(Ros2TrayTopics, ChangesAreSeenAndFramesPublished) {
  fast_dds_->subscribe(kTable, kTrays, false);
  fast_dds_->subscribe("rt/tf", "tf2_msgs::msg::dds_::TFMessage_", false);
  trays(kTable, [](const auto& read) { return read.size() == 4; });
  EXPECT_TRUE(take_until("rt/tf", [](const auto& sample) {
    const std::string name = "m2l1_kit_tray_05_mg_1";
    return std::ranges::search(sample, name).begin() != sample.end();
  }));
  v1::RemoveBodyRequest gear;
  gear.set_name("large_gear_2");
  v1::RemoveBodyResponse removed;
  grpc::ClientContext context;
  CellClient::require(cell_.control->RemoveBody(&context, gear, &removed));
  v1::MoveBodyRequest tray;  // to the other table
  tray.set_name("m2l1_05");
  tray.mutable_body_in_world()->mutable_position_m()->set_x(-0.66);
  tray.mutable_body_in_world()->mutable_position_m()->set_y(-1.9);
  tray.mutable_body_in_world()->mutable_position_m()->set_z(1);
  tray.mutable_body_in_world()->mutable_orientation()->set_w(1);
  v1::MoveBodyResponse moved;
  grpc::ClientContext other_context;
  CellClient::require(cell_.control->MoveBody(&other_context, tray, &moved));
  cell_.step(1);
  auto seen = trays(kTable, [](const auto& read) { return read.size() == 3; });
  EXPECT_FALSE(seen.contains("m2l1_kit_tray_05"));
  EXPECT_EQ(seen["large_gear_tray_04"].occupied, Names{});
}

}  // namespace
}  // namespace aprsim::test
