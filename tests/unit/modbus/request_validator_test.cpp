#include "modbus/request_validator.hpp"

#include <random>
#include <string>

#include <gtest/gtest.h>

#include "modbus/conformance_cases.hpp"
#include "tests/support/parameter_names.hpp"
#include "tests/unit/modbus/bytes.hpp"

namespace aprsim::modbus {
namespace {

using testing::adu;
using testing::Bytes;
using testing::conformance_cases;
using testing::ConformanceCase;
using testing::kAccepted;
using testing::pdu;
using testing::write_many;
using testing::zeros;

class Conformance : public ::testing::TestWithParam<ConformanceCase> {};

TEST_P(Conformance, IsJudgedAsTheSpecificationSays) {
  const Bytes bytes = adu(GetParam().pdu, 0xBEEF, 255);
  const ValidatedRequest validated = validate_request(bytes);
  EXPECT_EQ(validated.adu.size(), bytes.size());
  if (GetParam().exception == kAccepted) {
    ASSERT_EQ(validated.verdict, Verdict::kRequest);
    EXPECT_EQ(static_cast<int>(validated.request.function), GetParam().pdu[0]);
  } else {
    ASSERT_EQ(validated.verdict, Verdict::kRefused);
    EXPECT_EQ(static_cast<int>(validated.exception), GetParam().exception);
  }
}

INSTANTIATE_TEST_SUITE_P(RequestValidator, Conformance, ::testing::ValuesIn(conformance_cases()),
                         [](const auto& tested) { return tested.param.name; });

TEST(RequestValidator, EveryOtherFunctionIsIllegal) {
  for (int fc = 0; fc < 256; ++fc) {
    if ((fc >= 1 && fc <= 6) || fc == 15 || fc == 16 || fc == 22 || fc == 23) continue;
    if (fc == 43) continue;
    for (const std::size_t extra : {0U, 4U, 252U}) {
      Bytes body{static_cast<std::uint8_t>(fc)};
      body.resize(1 + extra, 0);
      const Bytes bytes = adu(body, 0x1234, 77);
      const ValidatedRequest validated = validate_request(bytes);
      ASSERT_EQ(validated.verdict, Verdict::kRefused) << fc;
      EXPECT_EQ(validated.exception, ExceptionCode::kIllegalFunction) << fc;
      const ExceptionReply reply = exception_reply(validated.adu, validated.exception);
      const Bytes expected{0x12, 0x34, 0, 0, 0, 3, 77, static_cast<std::uint8_t>(fc | 0x80), 1};
      EXPECT_EQ(Bytes(reply.bytes.begin(), reply.bytes.end()), expected) << fc;
    }
  }
}

Bytes identification(std::uint8_t level, std::uint8_t object) {
  const Bytes bytes = adu({43, 14, level, object}, 0x0102, 9);
  const ValidatedRequest validated = validate_request(bytes);
  EXPECT_EQ(validated.verdict, Verdict::kIdentification);
  return identification_reply(validated.adu, validated.identification);
}

/// The objects of a reply as "id=value;".
std::string objects(const Bytes& reply) {
  std::string text;
  std::size_t at = kHeaderSize + 7;
  for (int i = 0; i < reply.at(kHeaderSize + 6); ++i) {
    const std::size_t size = reply.at(at + 1);
    text += std::to_string(reply.at(at)) + "=";
    for (std::size_t j = 0; j < size; ++j) text += static_cast<char>(reply.at(at + 2 + j));
    text += ";";
    at += 2 + size;
  }
  EXPECT_EQ(at, reply.size());
  return text;
}

TEST(Identification, BasicStreamHasVendorProductAndRevision) {
  const Bytes reply = identification(1, 0);
  const Bytes head(reply.begin(), reply.begin() + kHeaderSize + 7);
  const auto length = static_cast<std::uint8_t>(reply.size() - 6);
  EXPECT_EQ(head, (Bytes{1, 2, 0, 0, 0, length, 9, 43, 14, 1, 0x82, 0, 0, 3}));
  const std::string text = objects(reply);
  EXPECT_EQ(text.find("0=aprsim;1=APRSIM-CONVEYOR;2="), 0U) << text;
}

TEST(Identification, StreamsBeginWhereAskedAndAtTheFirstForAnUnknownObject) {
  EXPECT_EQ(objects(identification(1, 1)).find("1=APRSIM-CONVEYOR;2="), 0U);
  EXPECT_EQ(identification(1, 3), identification(1, 0)) << "not a basic object";
  EXPECT_EQ(objects(identification(2, 3)).find("3="), 0U);
  EXPECT_EQ(objects(identification(2, 99)), objects(identification(2, 0)));
  EXPECT_EQ(identification(2, 0).at(kHeaderSize + 6), 7);
  EXPECT_EQ(objects(identification(3, 0)), objects(identification(2, 0))) << "no extended objects";
}

TEST(Identification, OneObjectAlone) {
  EXPECT_EQ(objects(identification(4, 0)), "0=aprsim;");
  EXPECT_EQ(objects(identification(4, 6)), "6=aprsimd;");
}

TEST(RequestRules, ReadOnlyRefusesWhatWritesAsAnUnknownFunction) {
  const RequestRules rules{.read_only = true};
  for (const std::uint8_t fc : Bytes{1, 2, 3, 4}) {
    EXPECT_EQ(validate_request(adu(pdu(fc, {0x8000, 1})), rules).verdict, Verdict::kRequest);
  }
  EXPECT_EQ(validate_request(adu({43, 14, 1, 0}), rules).verdict, Verdict::kIdentification);
  for (const std::uint8_t fc : Bytes{5, 6, 15, 16, 22, 23}) {
    const Bytes bytes = adu(pdu(fc, {0x8000, 1}));  // malformed or not
    const ValidatedRequest validated = validate_request(bytes, rules);
    EXPECT_EQ(validated.verdict, Verdict::kRefused) << int{fc};
    EXPECT_EQ(validated.exception, ExceptionCode::kIllegalFunction) << int{fc};
  }
}

TEST(RequestRules, OtherUnitsAreNotOurs) {
  const Bytes units{1, 255};
  const RequestRules rules{.unit_ids = units};
  for (int unit = 0; unit < 256; ++unit) {
    const Bytes bytes = adu(pdu(3, {0x8000, 1}), 1, static_cast<std::uint8_t>(unit));
    const ValidatedRequest validated = validate_request(bytes, rules);
    const bool ours = unit == 1 || unit == 255;
    EXPECT_EQ(validated.verdict, ours ? Verdict::kRequest : Verdict::kRefused) << unit;
    if (ours) continue;
    EXPECT_EQ(static_cast<int>(validated.exception), 11);
  }
}

TEST(RequestValidator, AnyUnitAndTransactionIdIsAcceptedAndEchoed) {
  for (int unit = 0; unit < 256; ++unit) {
    const auto transaction = static_cast<std::uint16_t>(unit * 257);
    const Bytes bytes = adu(pdu(3, {0x8000, 0}), transaction, static_cast<std::uint8_t>(unit));
    const ExceptionReply reply =
        exception_reply(validate_request(bytes).adu, ExceptionCode::kIllegalDataValue);
    EXPECT_EQ(reply.bytes[0], transaction >> 8);
    EXPECT_EQ(reply.bytes[1], transaction & 0xFF);
    EXPECT_EQ(reply.bytes[6], unit);
  }
}

TEST(RequestValidator, EveryPrefixOfARequestIsIncomplete) {
  const Bytes bytes = adu(write_many(16, 0x8000, 123, 246, zeros(246)));
  ASSERT_EQ(bytes.size(), kHeaderSize + 6 + 246);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const Bytes prefix(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    const ValidatedRequest validated = validate_request(prefix);
    EXPECT_EQ(validated.verdict, Verdict::kIncomplete) << size;
    EXPECT_TRUE(validated.adu.empty());
  }
}

TEST(RequestValidator, PipelinedRequestsComeOutOneByOne) {
  Bytes stream = adu(pdu(6, {0x8002, 15000}), 7);
  const Bytes second = adu(pdu(44, {0}), 8), third = adu(pdu(3, {0x8000, 3}), 9);
  stream.insert(stream.end(), second.begin(), second.end());
  stream.insert(stream.end(), third.begin(), third.end());

  std::span<const std::uint8_t> rest = stream;
  const ValidatedRequest a = validate_request(rest);
  ASSERT_EQ(a.verdict, Verdict::kRequest);
  EXPECT_EQ(a.request.address, 0x8002);
  EXPECT_EQ(a.request.word(0), 15000);
  rest = rest.subspan(a.adu.size());
  const ValidatedRequest b = validate_request(rest);
  EXPECT_EQ(b.verdict, Verdict::kRefused);
  EXPECT_EQ(b.adu[1], 8);
  rest = rest.subspan(b.adu.size());
  const ValidatedRequest c = validate_request(rest);
  ASSERT_EQ(c.verdict, Verdict::kRequest);
  EXPECT_EQ(c.request.quantity, 3);
  EXPECT_FALSE(c.request.is_write());
  EXPECT_EQ(c.adu.size(), rest.size());
}

TEST(RequestValidator, ImpossibleLengthsBreakTheStream) {
  for (const int length : {0, 1, 255, 256, 0x2F20, 0xFFFF}) {
    Bytes bytes = adu(pdu(3, {0x8000, 1}));
    bytes[4] = static_cast<std::uint8_t>(length >> 8);
    bytes[5] = static_cast<std::uint8_t>(length & 0xFF);
    EXPECT_EQ(validate_request(bytes).verdict, Verdict::kBroken) << length;
  }
}

TEST(RequestValidator, ALengthThatLiesWithinReasonOnlyHurtsItsOwnFrame) {
  // Too long: waits for bytes that belong to it. Too short: the frame ends where it says.
  Bytes longer = adu(pdu(6, {0x8000, 1}));
  longer[5] = 7;
  EXPECT_EQ(validate_request(longer).verdict, Verdict::kIncomplete);
  Bytes shorter = adu(pdu(6, {0x8000, 1}));
  shorter[5] = 4;
  const ValidatedRequest validated = validate_request(shorter);
  EXPECT_EQ(validated.verdict, Verdict::kRefused);
  EXPECT_EQ(validated.exception, ExceptionCode::kIllegalDataValue);
  EXPECT_EQ(validated.adu.size(), 10U);
}

TEST(RequestValidator, AnotherProtocolIsSkippedUnanswered) {
  for (const int protocol : {0x0001, 0x0100, 0xFFFF}) {
    const Bytes bytes = adu(pdu(6, {0x8000, 1}), 1, 1, static_cast<std::uint16_t>(protocol));
    const ValidatedRequest validated = validate_request(bytes);
    EXPECT_EQ(validated.verdict, Verdict::kIgnored);
    EXPECT_EQ(validated.adu.size(), bytes.size());
    EXPECT_FALSE(validated.reason.empty());
  }
}

TEST(RequestValidator, CoilValuesAreTakenFromTheirBits) {
  const Bytes bytes = adu(write_many(15, 0x8000, 10, 2, {0xCD, 0x01}));
  const ValidatedRequest validated = validate_request(bytes);
  ASSERT_EQ(validated.verdict, Verdict::kRequest);
  const std::vector<bool> expected{true, false, true, true, false, false, true, true, true, false};
  for (std::uint16_t i = 0; i < 10; ++i) EXPECT_EQ(validated.request.bit(i), expected[i]) << i;
}

TEST(RequestValidator, GarbageNeverYieldsMoreThanTheStreamHolds) {
  std::mt19937 random(1);
  int requests = 0;
  for (int round = 0; round < 200000; ++round) {
    Bytes bytes(random() % 40);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    // Half of them are made to look like Modbus, so that the deeper checks are reached.
    if (round % 2 == 0 && bytes.size() > 12) {
      bytes[2] = bytes[3] = bytes[4] = 0;
      bytes[5] = static_cast<std::uint8_t>(random() % 12);
      bytes[7] = static_cast<std::uint8_t>(random() % 18);
      bytes[8] = 0x80;
      bytes[10] = static_cast<std::uint8_t>(random() % 2);
    }
    const ValidatedRequest validated = validate_request(bytes);
    const bool taken = validated.verdict == Verdict::kRequest ||
                       validated.verdict == Verdict::kRefused ||
                       validated.verdict == Verdict::kIgnored;
    ASSERT_EQ(taken, !validated.adu.empty());
    ASSERT_LE(validated.adu.size(), bytes.size());
    if (validated.verdict != Verdict::kRequest) continue;
    ++requests;
    ASSERT_TRUE(is_mapped(validated.request.address, validated.request.quantity));
    ASSERT_GE(validated.request.quantity, 1);
    ASSERT_LE(validated.request.data.size(), validated.adu.size() - kHeaderSize - 3);
  }
  EXPECT_GT(requests, 100);
}

}  // namespace
}  // namespace aprsim::modbus
