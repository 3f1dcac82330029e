#include "protocols/access/audit_log.hpp"

#include <fstream>
#include <string>
#include <sys/stat.h>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "protocols/record/wire_tap.hpp"
#include "tests/support/fake_cell.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::protocols {
namespace {

class Audit : public testing::Test {
 protected:
  std::unique_ptr<AuditLog> open() {
    auto log = AuditLog::open(path, cell);
    EXPECT_TRUE(log) << log.error().message;
    return std::move(*log);
  }

  std::vector<nlohmann::json> lines() const {
    std::vector<nlohmann::json> all;
    std::ifstream in(path);
    for (std::string line; std::getline(in, line);) all.push_back(nlohmann::json::parse(line));
    return all;
  }

  test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/audit.jsonl";
  test::FakeCell cell;
};

TEST_F(Audit, KeepsEachCommandAsALine) {
  open()->write({.wire = "grpc",
                 .peer = "10.0.0.1:4711",
                 .identity = "token a \"b\"",
                 .command = "Pause",
                 .request = "line\nbreak",
                 .outcome = "ok"});
  const auto all = lines();
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0]["identity"], "token a \"b\"");
  EXPECT_EQ(all[0]["request"], "line\nbreak");
  EXPECT_EQ(all[0]["outcome"], "ok");
  EXPECT_EQ(all[0]["time"].get<std::string>().size(), 24U);
  struct stat status {};
  ASSERT_EQ(stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
}

TEST_F(Audit, GoesOnInItsFileAndCutsWhatIsLong) {
  for (int i = 0; i < 2; ++i)
    open()->write({.command = "c", .request = std::string(10'000, '\xFF')});
  ASSERT_EQ(lines().size(), 2U);
  // A sign of three bytes for each that is no UTF-8.
  EXPECT_EQ(lines()[1]["request"].get<std::string>().size(), 3 * AuditLog::kMaxRequest);
}

TEST_F(Audit, BeginsAnewWhenItsFileHasBeenMoved) {
  const auto log = open();
  log->write({.command = "before"});
  while (log->stats().records < 1) std::this_thread::yield();
  ASSERT_EQ(std::rename(path.c_str(), (path + ".1").c_str()), 0);
  ASSERT_TRUE(log->reopen());
  log->write({.command = "after"});
  while (log->stats().records < 2) std::this_thread::yield();
  ASSERT_EQ(lines().size(), 1U);
  EXPECT_EQ(lines()[0]["command"], "after");
}

TEST_F(Audit, NeverWaitsForADiskThatIsFull) {
  auto log = AuditLog::open("/dev/full", cell);
  ASSERT_TRUE(log) << log.error().message;
  for (int i = 0; i < 10'000; ++i) (*log)->write({.request = std::string(4000, 'x')});
  while ((*log)->stats().lost < 10'000) std::this_thread::yield();
  EXPECT_EQ((*log)->stats().records, 0U);
}

TEST_F(Audit, WhereItCannotBeWrittenIsAnError) {
  const auto log = AuditLog::open("/nonexistent/audit", cell);
  ASSERT_FALSE(log);
  EXPECT_EQ(log.error().message,
            "access.audit_file: cannot write /nonexistent/audit: No such file or directory");
}

TEST_F(Audit, HasTheCommandsOfTheWiresAndNotTheirPolls) {
  {
    const auto log = open();
    WireTap tap(cell);
    tap.audit_to(log.get());
    tap.want_polls(true);
    tap.record({.source = "crcl.fanuc",
                .peer = "p",
                .from_client = true,
                .type = "MoveToType",
                .data = "<a/>"});
    tap.record(
        {.source = "crcl.fanuc", .from_client = true, .poll = true, .type = "GetStatusType"});
    tap.record({.source = "crcl.fanuc", .type = "CRCLStatusType"});
    tap.record(
        {.source = "modbus", .peer = "q", .from_client = true, .data = {'\x00', '\x10', '\xff'}});
    tap.record({.source = "page", .from_client = true, .type = "pause"});
  }
  const auto all = lines();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0]["wire"], "crcl.fanuc");
  EXPECT_EQ(all[0]["command"], "MoveToType");
  EXPECT_EQ(all[0]["peer"], "p");
  EXPECT_EQ(all[1]["command"], "write");
  EXPECT_EQ(all[1]["request"], "0010ff");
}

}  // namespace
}  // namespace aprsim::protocols
