#include <locale>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "crcl/status_codec.hpp"
#include "tests/unit/crcl/golden.hpp"
#include "tests/unit/crcl/samples.hpp"

namespace aprsim::crcl {
namespace {

TEST(Statuses, EncodeAsTheGoldenDocuments) {
  EXPECT_EQ(encode_status(full_status()), golden("status_full.xml"));
  Status least;
  least.command = {{}, -1, 1, CommandState::kReady, {}, {}, {}, {}, {}};
  EXPECT_EQ(encode_status(least), golden("status_least.xml"));
  least.gripper =
      GripperStatus{"hand", {}, false, ThreeFingerGripper{{{0.5, {}, 1}}, {{{}, 2, {}}}}};
  EXPECT_EQ(encode_status(least), golden("status_three_finger.xml"));
  least.gripper = GripperStatus{"cup", {}, {}, VacuumGripper{true}};
  EXPECT_EQ(encode_status(least), golden("status_vacuum.xml"));
}

TEST(Statuses, ComeBackAsTheyWere) {
  Status status = full_status();
  EXPECT_EQ(decode_status(encode_status(status)).value(), status);
  status.gripper->kind = ThreeFingerGripper{{{0.5, {}, 1}}, {{{}, 2, {}}}};
  EXPECT_EQ(decode_status(encode_status(status)).value(), status);
  status.gripper->kind = VacuumGripper{true};
  status.joints.clear();
  status.settings.reset();
  EXPECT_EQ(decode_status(encode_status(status)).value(), status);
}

TEST(Statuses, EveryDescriptionSurvives) {
  EXPECT_TRUE(rc::check("text comes back unless XML cannot hold it", [] {
    const auto text = *rc::gen::container<std::string>(
        rc::gen::element('a', '<', '>', '&', '"', '\'', ' ', '\n', '\r', '\t', ']'));
    Status status;
    status.command.description = text;
    RC_ASSERT(decode_status(encode_status(status)).value().command.description == text);
  }));
}

TEST(Statuses, HoldNothingThatEndsThemEarly) {
  Status status;
  status.command.description = "</CRCLStatus>";
  const std::string document = encode_status(status);
  EXPECT_EQ(document.find("</CRCLStatus"), document.size() - std::string("</CRCLStatus>").size());
}

TEST(Statuses, IgnoreTheLocale) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale(), new Comma));
  const std::string document = encode_status(full_status());
  const Result<Status> status = decode_status(document);
  std::locale::global(before);
  EXPECT_EQ(document, golden("status_full.xml"));
  EXPECT_TRUE(status);
}

TEST(Statuses, AreReadLeniently) {
  const Result<Status> status = decode_status(
      "<CRCLStatus><Later/><CommandStatus><CommandState> CRCL_Working "
      "</CommandState></CommandStatus>"
      "<SensorStatuses><OnOffSensorStatus/></SensorStatuses><GuardsStatuses/></CRCLStatus>");
  ASSERT_TRUE(status) << status.error().message();
  EXPECT_EQ(status->command.state, CommandState::kWorking);
  EXPECT_EQ(status->command.command_id, 0);
  EXPECT_EQ(status->sensors->on_off.size(), 1U);
  EXPECT_EQ(status->guards->trigger_count, 0);
}

TEST(Statuses, ErrorsNameTheElement) {
  const Result<Status> status = decode_status(
      "<CRCLStatus><CommandStatus><CommandState>Busy</CommandState></CommandStatus></CRCLStatus>");
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message(),
            "CRCLStatus/CommandStatus/CommandState: 'Busy': expected CRCL_Done, CRCL_Error, "
            "CRCL_Working or CRCL_Ready");
}

}  // namespace
}  // namespace aprsim::crcl
