#include "server/programs/program_output.hpp"

#include <gtest/gtest.h>

namespace aprsim::server {
namespace {

using web::ProgramStatus;

TEST(ProgramOutput, ProgressIsTheLatest) {
  ProgramStatus status;
  EXPECT_FALSE(take_line(R"({"progress": {"time_s": 12.5, "placed": 3, "orders": [
      {"name": "urgent", "tray": "kit", "state": "open", "kits": 2, "done": 1, "parts": 5,
       "parts_wanted": 8}]}})",
                         status));
  EXPECT_EQ(status.time_s, 12.5);
  EXPECT_EQ(status.placed, 3U);
  ASSERT_EQ(status.orders.size(), 1U);
  EXPECT_EQ(status.orders[0].name, "urgent");
  EXPECT_EQ(status.orders[0].tray, "kit");
  EXPECT_EQ(status.orders[0].state, "open");
  EXPECT_EQ(status.orders[0].kits, 2U);
  EXPECT_EQ(status.orders[0].done, 1U);
  EXPECT_EQ(status.orders[0].parts, 5U);
  EXPECT_EQ(status.orders[0].parts_wanted, 8U);
  EXPECT_FALSE(take_line(R"({"progress": {"orders": []}})", status));
  EXPECT_TRUE(status.orders.empty());
  EXPECT_EQ(status.time_s, 0);
}

TEST(ProgramOutput, KeepsOutputAsLines) {
  ProgramStatus status;
  EXPECT_FALSE(take_line(R"({"time_s": 1.25, "event": "fault begins: belt-jam"})", status));
  EXPECT_FALSE(take_line(R"({"source": "fanuc", "text": "is ready", "at_s": 0.5})", status));
  EXPECT_EQ(status.lines,
            (std::vector<std::string>{"1.25 s: fault begins: belt-jam", "fanuc: is ready"}));
  EXPECT_FALSE(take_line(R"({"report": "kits 4\nright 3\n"})", status));
  EXPECT_EQ(status.report, "kits 4\nright 3\n");
}

TEST(ProgramOutput, LogsLinesThatAreNotJson) {
  ProgramStatus status;
  EXPECT_EQ(take_line("Traceback \x1b[31m(most recent call last):", status),
            "Traceback \\x1b[31m(most recent call last):");
  EXPECT_EQ(status.lines.size(), 1U);
  EXPECT_EQ(take_line("[1, 2]", status), "[1, 2]") << "no object";
}

TEST(ProgramOutput, IgnoresValuesOfAnotherType) {
  ProgramStatus status;
  EXPECT_FALSE(take_line(R"({"progress": {"time_s": "soon", "placed": -1, "orders": [
      7, {"name": 3, "kits": 1e300, "done": null}]}, "event": [], "report": {}})",
                         status));
  EXPECT_EQ(status.time_s, 0);
  EXPECT_EQ(status.placed, 0U);
  ASSERT_EQ(status.orders.size(), 1U);
  EXPECT_EQ(status.orders[0].name, "");
  EXPECT_EQ(status.orders[0].kits, 0U);
  EXPECT_TRUE(status.lines.empty());
  EXPECT_EQ(status.report, "");
}

TEST(ProgramOutput, KeepsNoMoreThanItSays) {
  ProgramStatus status;
  for (std::size_t i = 0; i < 3 * kMostLines; ++i) {
    (void)take_line("line " + std::to_string(i), status);
  }
  EXPECT_EQ(status.lines.size(), kMostLines);
  EXPECT_EQ(status.lines.back(), "line " + std::to_string(3 * kMostLines - 1));
  (void)take_line(std::string(100'000, 'x'), status);
  EXPECT_LE(status.lines.back().size(), kLongestText + 3);
  std::string orders;
  for (std::size_t i = 0; i < 2 * kMostOrders; ++i) orders += (i ? "," : "") + std::string("{}");
  (void)take_line(R"({"progress": {"orders": [)" + orders + "]}}", status);
  EXPECT_EQ(status.orders.size(), kMostOrders);
  (void)take_line(R"({"report": ")" + std::string(1'000'000, 'y') + "\"}", status);
  EXPECT_LE(status.report.size(), 2 * kLongestReport);
}

}  // namespace
}  // namespace aprsim::server
