#include "world/runtime/commands/command_results.hpp"

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

api::Snapshot written(const CommandResults& results) {
  api::Snapshot out;
  results.write(out);
  return out;
}

TEST(CommandResults, TheHighestTicketIsTheLatestApplied) {
  CommandResults results;
  EXPECT_EQ(written(results).applied, 0U);
  results.record(3, {});
  results.record(2, {});  // paced clients are sorted by endpoint
  EXPECT_EQ(written(results).applied, 3U);
  EXPECT_FALSE(written(results).failures);
}

TEST(CommandResults, TheLatestFailuresAreKept) {
  CommandResults results;
  results.record(1, fail(ErrorCode::kNotFound, "name", "first"));
  const api::Snapshot early = written(results);
  for (api::Ticket ticket = 2; ticket <= api::kMaxFailures + 1; ++ticket) {
    results.record(ticket, fail(ErrorCode::kUnavailable, "", "later"));
  }
  const auto failures = written(results).failures;
  ASSERT_EQ(failures->size(), api::kMaxFailures);
  EXPECT_EQ(failures->front().ticket, 2U);
  EXPECT_EQ(failures->back().ticket, api::kMaxFailures + 1);
  ASSERT_EQ(early.failures->size(), 1U) << "an earlier snapshot keeps its list";
  EXPECT_EQ(early.failures->front().error.message, "first");
}

}  // namespace
}  // namespace aprsim::world
