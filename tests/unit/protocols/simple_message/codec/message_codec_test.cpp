#include "protocols/simple_message/codec/message_codec.hpp"

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"

namespace aprsim::simple_message {
namespace {

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string from_hex(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return bytes;
}

std::string zeros(std::size_t words) { return std::string(4 * words, '\0'); }

struct SizeCase {
  std::string name;
  MessageType type;
  std::size_t body;
};

class RequestSize : public ::testing::TestWithParam<SizeCase> {};

TEST_P(RequestSize, IsThatOfItsType) {
  EXPECT_EQ(request_body_size(GetParam().type), GetParam().body);
}

INSTANTIATE_TEST_SUITE_P(
    MessageCodec, RequestSize,
    ::testing::Values(SizeCase{"Ping", MessageType::kPing, 0},
                      SizeCase{"JointPosition", MessageType::kJointPosition, 44},
                      SizeCase{"TrajectoryPoint", MessageType::kTrajectoryPoint, 52},
                      SizeCase{"RobotStatus", MessageType::kRobotStatus, 28},
                      SizeCase{"TrajectoryPointFull", MessageType::kTrajectoryPointFull, 136},
                      SizeCase{"JointFeedback", MessageType::kJointFeedback, 132},
                      SizeCase{"MotionControl", MessageType::kMotionControl, 52},
                      SizeCase{"MotionReply", MessageType::kMotionReply, 60},
                      SizeCase{"ReadIoBit", MessageType::kReadIoBit, 4},
                      SizeCase{"WriteIoBit", MessageType::kWriteIoBit, 8},
                      SizeCase{"ReadIoGroup", MessageType::kReadIoGroup, 4},
                      SizeCase{"WriteIoGroup", MessageType::kWriteIoGroup, 8},
                      SizeCase{"ReadRegister", MessageType::kReadRegister, 4},
                      SizeCase{"WriteRegister", MessageType::kWriteRegister, 8},
                      SizeCase{"Extended", MessageType::kTrajectoryPointsExtended, 8 + 4 * 132},
                      SizeCase{"FeedbackExtended", MessageType::kJointFeedbackExtended, 532},
                      SizeCase{"SelectTool", MessageType::kSelectTool, 12},
                      SizeCase{"DhParameters", MessageType::kDhParameters, 0}),
    [](const auto& tested) { return tested.param.name; });

TEST(MessageCodec, StatusIsBigEndianWithItsFieldsInOrder) {
  const Message message{MessageType::kRobotStatus, Communication::kTopic, ReplyCode::kNone,
                        RobotStatus{1, 0, 4321, 1, 0, kAutomaticMode, -1}};
  EXPECT_EQ(encode(message, ByteOrder::kBig),
            from_hex("000000280000000d0000000100000000"
                     "0000000100000000000010e1000000010000000000000002ffffffff"));
}

TEST(MessageCodec, LittleEndianTurnsEveryWord) {
  const Message message{MessageType::kWriteIoBitReply, Communication::kServiceReply,
                        ReplyCode::kFailure, WriteIoReply{1002}};
  EXPECT_EQ(encode(message, ByteOrder::kLittle),
            from_hex("10000000d60700000300000002000000ea030000"));
}

TEST(MessageCodec, PositionReplyOfTheFanucHas56BytesAfterItsLength) {
  const Message message{MessageType::kJointPosition, Communication::kServiceReply,
                        ReplyCode::kSuccess, JointPosition{7, {}}};
  const std::string bytes = encode(message, ByteOrder::kBig);
  EXPECT_EQ(bytes, from_hex("000000380000000a000000030000000100000007") + zeros(10));
}

TEST(MessageCodec, FeedbackStates144BytesAfterItsLength) {
  const Message message{MessageType::kJointFeedback, Communication::kTopic, ReplyCode::kNone,
                        JointFeedback{0, kPositionValid | kVelocityValid, 0, {1}, {}, {}}};
  const std::string bytes = encode(message, ByteOrder::kBig);
  EXPECT_EQ(bytes.substr(0, 32),
            from_hex("000000900000000f00000001000000000000000000000006000000003f800000"));
  EXPECT_EQ(bytes.size(), 4U + 144U);
}

TEST(MessageCodec, PointOfTheMotomanIsReadDespiteItsWrongLength) {
  // The client states 136; 148 follow.
  const std::string bytes = from_hex("000000880000000e0000000200000000") +
                            from_hex("0000000000000003000000073dcccccd") + from_hex("3f800000") +
                            zeros(9) + from_hex("bf000000") + zeros(19);
  ASSERT_EQ(bytes.size(), 4U + 148U);
  const auto message = decode_request(bytes_of(bytes), ByteOrder::kBig);
  ASSERT_TRUE(message.has_value()) << message.error().message;
  const auto& point = std::get<TrajectoryPointFull>(message->body);
  EXPECT_EQ(point.sequence, 3);
  EXPECT_EQ(point.valid, 7);
  EXPECT_FLOAT_EQ(point.time, 0.1F);
  EXPECT_FLOAT_EQ(point.position[0], 1);
  EXPECT_FLOAT_EQ(point.velocity[0], -0.5F);
}

TEST(MessageCodec, MotionReplyCarriesResultAndSubcode) {
  const MotionReply reply{0,
                          5,
                          14,
                          static_cast<std::int32_t>(MotionResult::kInvalid),
                          static_cast<std::int32_t>(Subcode::kStartPosition),
                          {}};
  const std::string bytes =
      encode({MessageType::kMotionReply, Communication::kServiceReply, ReplyCode::kSuccess, reply},
             ByteOrder::kBig);
  EXPECT_EQ(bytes, from_hex("00000048000007d200000003000000010000000000000005"
                            "0000000e0000000300000bc3") +
                       zeros(10));
  const auto message = decode_reply(bytes_of(bytes), ByteOrder::kBig);
  ASSERT_TRUE(message.has_value());
  EXPECT_EQ(std::get<MotionReply>(message->body).subcode, 3011);
}

TEST(MessageCodec, RegisterRepliesHaveTheTypeOfTheirRequest) {
  const Message message{MessageType::kReadRegister, Communication::kServiceReply,
                        ReplyCode::kSuccess, ReadIoReply{42, 0}};
  const std::string bytes = encode(message, ByteOrder::kBig);
  const auto reply = decode_reply(bytes_of(bytes), ByteOrder::kBig);
  ASSERT_TRUE(reply.has_value());
  EXPECT_EQ(std::get<ReadIoReply>(reply->body).value, 42);
  const auto request = decode_request(bytes_of(bytes), ByteOrder::kBig);
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(std::get<ReadIo>(request->body).address, 42);
}

TEST(MessageCodec, ErrorsNameTheField) {
  const auto field_of = [](const std::string& bytes) {
    const auto message = decode_request(bytes_of(bytes), ByteOrder::kBig);
    return message ? std::string("none") : message.error().field;
  };
  EXPECT_EQ(field_of(from_hex("00000028")), "length");
  EXPECT_EQ(field_of(from_hex("0000000c000003e70000000200000000")), "type");
  EXPECT_EQ(field_of(from_hex("0000000c000007d30000000200000000")), "length");
  const std::string header = from_hex("000000380000000a0000000200000000");
  EXPECT_EQ(field_of(header + zeros(3) + from_hex("7fc00000") + zeros(7)), "position[2]");
  EXPECT_EQ(field_of(header + zeros(10) + from_hex("ff800000")), "position[9]");
  EXPECT_EQ(field_of(header + zeros(11)), "none");
  const std::string point = from_hex("000000400000000b0000000200000000") + zeros(11);
  EXPECT_EQ(field_of(point + from_hex("7f800000") + zeros(1)), "velocity");
}

TEST(MessageCodec, UnusedGroupsMayBeLeftOut) {
  const std::string header = from_hex("000000a4000007e00000000200000000");
  const std::string one = from_hex("0000000100000009") + zeros(33);
  const auto message = decode_request(bytes_of(header + one), ByteOrder::kBig);
  ASSERT_TRUE(message.has_value()) << message.error().message;
  EXPECT_EQ(std::get<TrajectoryPointsExtended>(message->body).sequence, 9);
  const std::string two = from_hex("0000000200000009") + zeros(33);
  EXPECT_FALSE(decode_request(bytes_of(header + two), ByteOrder::kBig).has_value());
}

TEST(MessageCodec, WordsOfTheGripper) {
  EXPECT_EQ(encode_word(99, ByteOrder::kBig), from_hex("00000063"));
  const std::string bytes = from_hex("00000003");
  EXPECT_EQ(decode_word(bytes_of(bytes).first<4>(), ByteOrder::kBig), 3);
}

}  // namespace
}  // namespace aprsim::simple_message
