#include "clients/aprsim/trace/comparison.hpp"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "clients/aprsim/trace/exports.hpp"
#include "clients/aprsim/trace/listing.hpp"
#include "tests/support/journal_file.hpp"
#include "tests/support/temporary_directory.hpp"
#include "world/base/utf8.hpp"

namespace aprsim::trace {
namespace {

using test::JournalFile;

std::string write_request(std::uint16_t transaction, std::uint16_t address, std::uint16_t value) {
  const auto high = [](std::uint16_t word) { return static_cast<char>(word >> 8); };
  const auto low = [](std::uint16_t word) { return static_cast<char>(word & 0xff); };
  return {high(transaction), low(transaction), 0,           0,         0, 6, 1, 6,
          high(address),     low(address),     high(value), low(value)};
}

/// Behaviour of a controller that the tests vary.
struct Job {
  double x_mm = 411;        ///< of the third move
  double speed_mm_s = 100;  ///< of the second
  double dwell_s = 0.2;
  bool grips = true;
  bool grips_twice = false;
  bool swapped = false;  ///< the first two moves
  std::uint16_t belt = 10000;
  std::int64_t first_id = 4;
  double poll_s = 0.025;
  double late_s = 0;      ///< before the third move
  double end_x_mm = 411;  ///< where it says that it is
  std::string end = "CRCL_Done";
  bool reads_more = false;
  double seen_x_mm = 100;
};

std::string move_to(double x, double y, double z) {
  return "<MoveStraight>true</MoveStraight>" + JournalFile::pose("EndPosition", x, y, z);
}

Trace trace_of(const Job& job, const std::string& run = "run") {
  const std::string fanuc = "crcl.fanuc";
  JournalFile file(run);
  file.poll_s = job.poll_s;
  std::int64_t id = job.first_id;
  double at = file.command(fanuc, 1, id++, "InitCanonType", "");
  at = file.command(fanuc, at, id++, "SetTransSpeedType",
                    "<TransSpeed xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
                    "xsi:type=\"TransSpeedAbsoluteType\"><Setting>" +
                        std::to_string(job.speed_mm_s) + "</Setting></TransSpeed>");
  const std::string one = move_to(300, 0, 200), two = move_to(400, 50, 200);
  at = file.command(fanuc, at, id++, "MoveToType", job.swapped ? two : one, 1.2);
  at = file.command(fanuc, at, id++, "MoveToType", job.swapped ? one : two, 1.5);
  at = file.command(
      fanuc, at + job.late_s, id++, "MoveToType", move_to(job.x_mm, 0, 20), 1.3,
      "<PoseStatus>" + JournalFile::pose("Pose", job.end_x_mm, 0, 20) + "</PoseStatus>", job.end);
  for (int i = 0; i < (job.grips ? 1 : 0) + (job.grips_twice ? 1 : 0); ++i) {
    at = file.command(fanuc, at, id++, "SetEndEffectorType", "<Setting>0</Setting>", 0.5);
  }
  at = file.command(fanuc, at, id++, "DwellType",
                    "<DwellTime>" + std::to_string(job.dwell_s) + "</DwellTime>", job.dwell_s);
  const auto transaction = static_cast<std::uint16_t>(job.first_id);
  file.received("modbus", at, write_request(transaction, 0x8002, job.belt), 9);
  file.sent("modbus", at + 0.01, write_request(transaction, 0x8002, job.belt), 9);
  const std::string read{0, 77, 0, 0, 0, 6, 1, 4, '\x80', job.reads_more ? '\x08' : '\x04', 0, 2};
  file.received("modbus", at + 0.02, read, 9);
  for (int frame = 0; frame < 20; ++frame) {
    file.sent("vision.fanuc", at + 0.1 * frame,
              "part_large_gear,0.1," + std::to_string(job.seen_x_mm + 0.3 * (frame % 3)) +
                  ",50.0,0.97,P,sg,,,,,P,\n");
  }
  const test::TemporaryDirectory directory;
  const std::string place = directory.path() + "/run.journal";
  file.write(place);
  auto trace = read_trace(place);
  EXPECT_TRUE(trace) << (trace ? "" : trace.error().message);
  return *trace;
}

Comparison changed(const std::function<void(Job&)>& change, const Tolerance& tolerance = {}) {
  Job job;
  change(job);
  return compare(trace_of(Job()), trace_of(job), tolerance);
}

std::string first(const Comparison& comparison) {
  return comparison.same() ? "same" : comparison.deviations.front().text;
}

TEST(TraceComparison, NumbersPollsAndJitterAreNoDeviation) {
  EXPECT_EQ(first(changed([](Job&) {})), "same");
  EXPECT_EQ(first(changed([](Job& job) { job.first_id = 1004; })), "same");
  EXPECT_EQ(first(changed([](Job& job) { job.poll_s = 0.007; })), "same");
  EXPECT_EQ(first(changed([](Job& job) { job.late_s = 0.3; })), "same");
  EXPECT_EQ(first(changed([](Job& job) { job.x_mm = job.end_x_mm = 411.3; })), "same");
  EXPECT_EQ(first(changed([](Job& job) { job.seen_x_mm = 103; })), "same");
}

TEST(TraceComparison, ReportsDifferentCommands) {
  EXPECT_EQ(first(changed([](Job& job) { job.x_mm = 412; })),
            "fanuc, command 5 MoveTo: x 1.00 mm farther (412.00 mm, was 411.00 mm)");
  EXPECT_EQ(first(changed([](Job& job) { job.speed_mm_s = 80; })),
            "fanuc, command 2 SetTransSpeed: speed 20.0 mm/s slower (80.0 mm/s, was 100.0 mm/s)");
  EXPECT_EQ(first(changed([](Job& job) { job.dwell_s = 0.1; })),
            "fanuc, command 7 Dwell: time 0.100 s shorter (0.100 s, was 0.200 s)");
  EXPECT_EQ(first(changed([](Job& job) { job.grips = false; })),
            "fanuc, command 6 SetEndEffector is missing (setting 0.0 %)");
  EXPECT_EQ(first(changed([](Job& job) { job.grips_twice = true; })),
            "fanuc, command 7 SetEndEffector is repeated (setting 0.0 %)");
  EXPECT_EQ(first(changed([](Job& job) { job.swapped = true; })),
            "fanuc, command 3 MoveTo comes later, as command 4");
  EXPECT_EQ(first(changed([](Job& job) { job.belt = 12000; })),
            "modbus, write 1 write speed: speed 2000 more (12000, was 10000)");
}

TEST(TraceComparison, ReportsDifferentResults) {
  EXPECT_EQ(first(changed([](Job& job) { job.late_s = 0.8; })),
            "fanuc, command 5 MoveTo: comes 0.80 s later (0.800 s, was 0.000 s, after the "
            "previous action)");
  EXPECT_EQ(first(changed([](Job& job) { job.end_x_mm = 409; })),
            "fanuc, command 5 MoveTo: ends with tool x 2.00 mm nearer (409.00 mm, was 411.00 mm)");
  EXPECT_EQ(first(changed([](Job& job) { job.end = "CRCL_Error"; })),
            "fanuc, command 5 MoveTo: ends with an error, was done");
  EXPECT_EQ(first(changed([](Job& job) { job.seen_x_mm = 110; })),
            "vision.fanuc: in the end part_large_gear at (100.3, 50.0) mm lies 10.0 mm elsewhere, "
            "at (110.3, 50.0) mm");
}

TEST(TraceComparison, OnePairIsOneDeviationAndWorstComeFirst) {
  const auto comparison = changed([](Job& job) {
    job.speed_mm_s = 99;  // at the limit: the same
    job.x_mm = 412;
    job.end_x_mm = 412;
    job.grips = false;
    job.belt = 10001;
  });
  ASSERT_EQ(comparison.deviations.size(), 3U);
  EXPECT_EQ(comparison.deviations[0].kind, DeviationKind::kValue);
  EXPECT_DOUBLE_EQ(comparison.deviations[0].weight, 2);
  const auto worst = comparison.worst(2);
  ASSERT_EQ(worst.size(), 2U);
  EXPECT_EQ(worst[0]->kind, DeviationKind::kMissing);
  EXPECT_EQ(worst[1]->wire, "modbus");
}

TEST(TraceComparison, TolerancesApply) {
  Tolerance wide;
  wide.position_mm = 1.5;
  wide.end_mm = 2;
  EXPECT_EQ(first(changed([](Job& job) { job.x_mm = job.end_x_mm = 412; }, wide)), "same");
  wide.register_counts = 2000;
  EXPECT_EQ(first(changed([](Job& job) { job.belt = 12000; }, wide)), "same");
  Tolerance narrow;
  narrow.time_s = 0.1;
  narrow.time_percent = 0;
  EXPECT_NE(first(changed([](Job& job) { job.late_s = 0.3; }, narrow)), "same");
}

TEST(TraceComparison, RegistersThatOnlyOneOfBothReads) {
  const auto comparison = changed([](Job& job) { job.reads_more = true; });
  ASSERT_EQ(comparison.deviations.size(), 2U);
  EXPECT_EQ(comparison.deviations[0].kind, DeviationKind::kRead);
  EXPECT_EQ(comparison.deviations[1].text,
            "modbus: reads input registers 0x8008 to 0x8009, 1 times, which was never read");
}

TEST(TraceComparison, FinalSceneComesLast) {
  const auto comparison = changed([](Job& job) {
    job.seen_x_mm = 110;
    job.belt = 1;
  });
  ASSERT_EQ(comparison.deviations.size(), 2U);
  EXPECT_EQ(comparison.deviations[1].kind, DeviationKind::kSeen);
}

TEST(TraceComparison, UnitsOfTheConnectionAreNoDeviation) {
  const auto in_units = [](const std::string& unit, double x) {
    JournalFile file;
    double at =
        file.command("crcl.fanuc", 1, 1, "SetLengthUnitsType", "<UnitName>" + unit + "</UnitName>");
    file.command("crcl.fanuc", at, 2, "MoveToType", move_to(x, 0, 0));
    const test::TemporaryDirectory directory;
    file.write(directory.path() + "/a.journal");
    return *read_trace(directory.path() + "/a.journal");
  };
  const auto comparison = compare(in_units("millimeter", 254), in_units("inch", 10), {});
  // That the unit was set otherwise is one.
  ASSERT_EQ(comparison.deviations.size(), 1U);
  EXPECT_EQ(comparison.deviations[0].command, "SetLengthUnits");
}

TEST(TraceComparison, ChanceObservationsAreNoDeviation) {
  // These are the states that polls see of a program of four commands and of a gripper.
  const auto seeing = [](const std::vector<std::int64_t>& seen, bool gripper_seen) {
    JournalFile file;
    std::string program = "<CRCLProgram xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">";
    program += "<InitCanon><CommandID>1</CommandID></InitCanon>";
    for (const char* id : {"2", "3"}) {
      program += "<MiddleCommand xsi:type=\"DwellType\"><CommandID>" + std::string(id) +
                 "</CommandID><DwellTime>0.1</DwellTime></MiddleCommand>";
    }
    file.received("crcl.fanuc", 1,
                  program + "<EndCanon><CommandID>4</CommandID></EndCanon></CRCLProgram>");
    for (const std::int64_t id : seen) {
      file.sent("crcl.fanuc", 1 + 0.1 * static_cast<double>(id),
                JournalFile::status(id, "CRCL_Done", ""));
    }
    file.received("crcl.motoman", 1,
                  JournalFile::instance(1, "SetEndEffectorType", "<Setting>0</Setting>"), 2);
    if (gripper_seen) file.sent("crcl.motoman", 1.02, JournalFile::status(1, "CRCL_Done", ""), 2);
    file.received("crcl.motoman", 1.05,
                  JournalFile::instance(2, "DwellType", "<DwellTime>0.2</DwellTime>"), 2);
    file.sent("crcl.motoman", 1.3, JournalFile::status(2, "CRCL_Done", ""), 2);
    const test::TemporaryDirectory directory;
    file.write(directory.path() + "/a.journal");
    return *read_trace(directory.path() + "/a.journal");
  };
  const Trace all = seeing({1, 2, 3, 4}, true);
  EXPECT_EQ(first(compare(all, seeing({2, 4}, true), {})), "same");
  EXPECT_EQ(first(compare(all, seeing({4}, false), {})), "same");
  EXPECT_EQ(first(compare(seeing({1, 4}, false), all, {})), "same");
  EXPECT_EQ(first(compare(all, seeing({1, 2}, true), {})),
            "fanuc, command 3 program's Dwell: ends with no end, was done");
}

TEST(TraceComparison, WireOfOneRunOnly) {
  JournalFile one;
  one.command("crcl.fanuc", 1, 1, "InitCanonType", "");
  one.command("crcl.motoman", 1, 1, "InitCanonType", "");
  one.received("grpc", 2, "");
  JournalFile other;
  other.command("crcl.fanuc", 1, 1, "InitCanonType", "");
  const test::TemporaryDirectory directory;
  const std::string a = directory.path() + "/a", b = directory.path() + "/b";
  one.write(a);
  other.write(b);
  const auto comparison = compare(*read_trace(a), *read_trace(b), {});
  ASSERT_EQ(comparison.deviations.size(), 1U);
  EXPECT_EQ(comparison.deviations[0].text, "B has no traffic on crcl.motoman (A has 1 command)");
  // A capture has no calls of gRPC.
  ASSERT_EQ(comparison.notes.size(), 1U);
}

TEST(TraceComparison, RepliesArePairedWhenEveryTransactionHasOneNumber) {
  // Transaction 0 for all requests, of which two are under way at a time.
  const auto outcomes = [](bool second_fails) {
    JournalFile file;
    const std::string speed = write_request(0, 0x8002, 10000), run = write_request(0, 0x8001, 1);
    file.received("modbus", 1, speed, 9);
    file.received("modbus", 1.01, run, 9);
    file.sent("modbus", 1.02, speed, 9);
    const std::string refusal{0, 0, 0, 0, 0, 3, 1, '\x86', 4};
    file.sent("modbus", 1.03, second_fails ? refusal : run, 9);
    const test::TemporaryDirectory directory;
    file.write(directory.path() + "/a.journal");
    std::vector<std::string> out;
    const auto trace = read_trace(directory.path() + "/a.journal");
    const auto wires = actions_of(*trace);
    for (const Action& action : wires.at("modbus").actions) {
      out.push_back(action.outcome);
    }
    return out;
  };
  const auto done = outcomes(false), refused = outcomes(true);
  ASSERT_EQ(done.size(), 2U);
  EXPECT_EQ(done[0], "done");
  EXPECT_EQ(done[1], "done");
  ASSERT_EQ(refused.size(), 2U);
  EXPECT_EQ(refused[0], "done");
  EXPECT_NE(refused[1], "done");
}

/// A journal with one line of a camera.
std::string journal_with_line(const test::TemporaryDirectory& directory, const std::string& line) {
  JournalFile file;
  file.sent("vision.fanuc", 1, line);
  const std::string place = directory.path() + "/a.journal";
  file.write(place);
  return place;
}

TEST(TraceListing, CutsALongLineBetweenTwoCharacters) {
  const test::TemporaryDirectory directory;
  for (int before = 0; before < 4; ++before) {
    std::string line(static_cast<std::size_t>(290 + before), 'a');
    for (int i = 0; i < 20; ++i) line += "\xe2\x82\xac";
    const auto place = journal_with_line(directory, line + "\n");
    std::string listed;
    ASSERT_TRUE(
        list_trace(place, {.polls = true}, [&](const ListedLine& one) { listed = one.text; }));
    EXPECT_TRUE(utf8::is_valid(listed)) << before;
    EXPECT_TRUE(listed.ends_with(" ...")) << listed;
    const std::string out = directory.path() + "/csv";
    ASSERT_TRUE(export_csv(place, "", out));
    std::ifstream in(out + "/wires.csv", std::ios::binary);
    EXPECT_TRUE(utf8::is_valid(std::string(std::istreambuf_iterator<char>(in), {}))) << before;
  }
}

TEST(TraceListing, ControlCharactersAreEscaped) {
  const test::TemporaryDirectory directory;
  const auto place = journal_with_line(directory, "\x1b]0;title\x07 \xc2\x9b\xff\n");
  std::string listed;
  ASSERT_TRUE(
      list_trace(place, {.polls = true}, [&](const ListedLine& one) { listed = one.text; }));
  EXPECT_NE(listed.find("\\x1b]0;title\\x07 \\xc2\\x9b\\xff"), std::string::npos) << listed;
}

TEST(TraceExport, OverTheRunItselfIsRefused) {
  const test::TemporaryDirectory directory;
  const auto place = journal_with_line(directory, "text\n");
  std::filesystem::create_hard_link(place, directory.path() + "/b");
  EXPECT_FALSE(check_exports(place, {place}));
  EXPECT_FALSE(check_exports(place, {directory.path() + "/b"}));
  EXPECT_FALSE(check_exports(place, {directory.path() + "/new", directory.path() + "/new"}));
  EXPECT_TRUE(check_exports(place, csv_files(directory.path() + "/csv")));
}

TEST(TraceReading, FilesOfOneRunInTheirOrder) {
  const test::TemporaryDirectory directory;
  const std::string first = directory.path() + "/a.journal";
  JournalFile one("run", 1), two("run", 2), other("other", 1);
  one.command("crcl.fanuc", 1, 1, "InitCanonType", "");
  two.command("crcl.fanuc", 2, 2, "EndCanonType", "");
  one.write(first, /*ended=*/false);
  two.write(first + ".2");
  for (const std::string& place : {first, directory.path()}) {
    const auto trace = read_trace(place);
    ASSERT_TRUE(trace) << trace.error().message;
    ASSERT_EQ(actions_of(*trace).at("crcl.fanuc").actions.size(), 2U) << place;
    EXPECT_TRUE(trace->notes.empty()) << trace->notes.front();
  }
  other.write(directory.path() + "/b.journal");
  const auto mixed = read_trace(directory.path());
  ASSERT_FALSE(mixed);
  EXPECT_NE(mixed.error().message.find("several runs"), std::string::npos);
}

TEST(TraceReading, TruncatedJournalIsReadAndNoted) {
  const test::TemporaryDirectory directory;
  const std::string file = directory.path() + "/a.journal";
  JournalFile one;
  one.command("crcl.fanuc", 1, 1, "InitCanonType", "");
  one.write(file, /*ended=*/false);
  const auto open = read_trace(file);
  ASSERT_TRUE(open);
  ASSERT_EQ(open->notes.size(), 1U);
  EXPECT_NE(open->notes[0].find("does not end"), std::string::npos);
  std::ofstream(file, std::ios::binary | std::ios::app) << "half a frame";
  const auto damaged = read_trace(file);
  ASSERT_TRUE(damaged);
  EXPECT_EQ(damaged->wires.size(), open->wires.size());
  EXPECT_EQ(damaged->notes.size(), 2U);
}

}  // namespace
}  // namespace aprsim::trace
