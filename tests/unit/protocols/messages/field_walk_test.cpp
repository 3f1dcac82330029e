// Values as messages by their lists of fields.

#include <string>
#include <vector>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include "protocols/messages/codecs.hpp"
#include "protocols/messages/history_message.hpp"
#include "tests/support/filled.hpp"
#include "world/api/description/description_fields.hpp"
#include "world/api/ports/history_fields.hpp"
#include "world/api/snapshot/snapshot_fields.hpp"

namespace aprsim::protocols {
namespace {

namespace pb = google::protobuf;

/// Adds the names of all fields that are absent or zero in a message and in those in it.
void find_absent(const pb::Message& message, std::vector<std::string>& absent) {
  const pb::Descriptor& type = *message.GetDescriptor();
  const pb::Reflection& values = *message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    const pb::OneofDescriptor* oneof = field.real_containing_oneof();
    const bool is_message = field.cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE;
    if (field.is_repeated()) {
      const int size = values.FieldSize(message, &field);
      if (size == 0) absent.push_back(field.full_name());
      for (int k = 0; is_message && !field.is_map() && k < size; ++k) {
        find_absent(values.GetRepeatedMessage(message, &field, k), absent);
      }
    } else if (oneof != nullptr ? !values.HasOneof(message, oneof)
                                : !values.HasField(message, &field)) {
      absent.push_back(field.full_name());
    } else if (is_message && values.HasField(message, &field)) {
      find_absent(values.GetMessage(message, &field), absent);
    }
  }
}

std::vector<std::string> absent_of(const pb::Message& message) {
  std::vector<std::string> absent;
  find_absent(message, absent);
  return absent;
}

using Names = std::vector<std::string>;

TEST(FieldWalk, WritesEveryFieldOfASnapshot) {
  auto snapshot = test::filled<api::Snapshot>();
  v1::Snapshot message;
  write_message(snapshot, "instance", message);
  // Time that a client was left behind in is not reproducible.
  EXPECT_EQ(absent_of(message), Names{"aprsim.v1.VirtualTime.reproducible"});
}

TEST(FieldWalk, WritesEveryFieldOfACell) {
  auto cell = test::filled<api::CellDescription>();
  // Fixtures and pieces have no lists of fields.
  const Pose pose{{1, 2, 3}, {0.5, 0.5, 0.5, 0.5}};
  for (auto& fixture : cell.fixtures) {
    fixture = {"fixture", pose, {{api::BoxPiece{{1, 2, 3}}, pose}}};
  }
  // Outlines of pockets lie in the plane z = 0.
  std::size_t corners = 0;
  for (const auto& body : cell.bodies) {
    for (const auto& slot : body.slots) corners += slot.pocket_outline.size();
  }
  for (const auto kind : {api::BodyKind::kGear, api::BodyKind::kKitTray}) {
    for (auto& body : cell.bodies) body.kind = kind;
    v1::CellDescription message;
    write_message(cell, message);
    Names absent(kind == api::BodyKind::kKitTray ? corners : 0, "aprsim.v1.Vector3.z");
    // Each camera has a carrier: its pose is in that flange.
    absent.resize(absent.size() + cell.cameras.size(),
                  "aprsim.v1.CameraDescription.camera_in_world");
    // A gear is the first kind of its enumeration, which begins with an unspecified one.
    EXPECT_EQ(absent_of(message), absent);
  }
}

TEST(FieldWalk, WritesEveryFieldOfEventsAndOfThePast) {
  v1::CellEvent event;
  write_message(test::filled<api::CellEvent>(), event);
  EXPECT_EQ(absent_of(event), Names{});
  v1::Bookmark bookmark;
  write_message(test::filled<api::Bookmark>(), bookmark);
  EXPECT_EQ(absent_of(bookmark), Names{});
  v1::GetHistoryResponse spans;
  write_message({test::filled<api::HistorySpan>()}, spans);
  EXPECT_EQ(absent_of(spans), Names{});
}

TEST(FieldWalk, ANegativeIndexIsAbsent) {
  api::ToolSnapshot tool;
  v1::ToolState message;
  write_fields(tool, message);
  EXPECT_FALSE(message.has_robot());
  tool.robot = 0;
  write_fields(tool, message);
  EXPECT_TRUE(message.has_robot());
}

TEST(FieldWalk, AFieldThatIsAbsentLeavesItsMember) {
  api::Guard guard;
  v1::Guard message;
  message.set_signal(v1::GUARD_SIGNAL_SEPARATION);
  message.set_limit(v1::GUARD_LIMIT_INCREASED);
  message.set_value(0.5);
  ASSERT_TRUE(read_fields(message, guard));
  EXPECT_EQ(guard.signal.kind, api::SignalKind::kSeparation);
  EXPECT_EQ(guard.limit, api::GuardLimit::kIncreased);
  EXPECT_EQ(guard.value, 0.5);
  EXPECT_EQ(guard.recheck, api::kGuardRecheck);
}

TEST(FieldWalk, NamesWhatItDoesNotKnow) {
  api::Guard guard;
  v1::Guard message;
  EXPECT_EQ(read_fields(message, guard).error().field, "guard's signal");
  message.set_signal(v1::GUARD_SIGNAL_SEPARATION);
  message.set_limit(static_cast<v1::GuardLimit>(77));
  EXPECT_EQ(read_fields(message, guard).error().field, "guard's limit");
}

}  // namespace
}  // namespace aprsim::protocols
