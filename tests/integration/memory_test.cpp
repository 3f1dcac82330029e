// The memory of a daemon over simulated hours, and what /metrics says of it.

#include <csignal>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/raw_web_client.hpp"
#include "tests/support/resident_memory.hpp"
#include "tests/support/slope.hpp"

namespace aprsim::test {
namespace {

/// A second of simulated time with as many events as an hour of kitting has in a minute.
void live_a_second(CellClient& cell, int number) {
  constexpr int kReports = 40;
  for (int i = 0; i < kReports; ++i) {
    v1::ReportEventRequest request;
    request.set_event("order_" + std::to_string(number) + "_part_" + std::to_string(i));
    v1::ReportEventResponse response;
    grpc::ClientContext context;
    CellClient::require(cell.control->ReportEvent(&context, request, &response));
  }
  cell.step(1000);
}

/// Measured in simulated time, so that the machine's speed does not decide.
TEST(MemoryOfADaemon, StaysFlatOnceItsPastIsFull) {
  DaemonProcess daemon({"--scene", "empty_belt", "--speed", "stepped", "--no-web", "--set",
                        "history.minutes=1", "--set", "journal.memory_minutes=1"});
  CellClient cell(daemon.port("grpc"));
  // One minute fills history and journal. The event log and the allocator's pools follow in
  // the second one.
  constexpr int kWarmUp_s = 150, kMeasured_s = 240;
  std::vector<double> memory_mb;
  for (int second = 0; second < kWarmUp_s + kMeasured_s; ++second) {
    live_a_second(cell, second);
    if (second >= kWarmUp_s) memory_mb.push_back(resident_mb(daemon.pid()));
  }
  // An event log without a bound grows by 3 MB meanwhile, pools of a busy machine by 0.2 MB.
  const double growth_mb = median_slope(memory_mb) * kMeasured_s;
  EXPECT_LT(growth_mb, 1.0) << memory_mb.front() << " MB became " << memory_mb.back();
  RecordProperty("growth_mb", std::to_string(growth_mb));
}

TEST(MemoryOfADaemon, IsToldByPart) {
  DaemonProcess daemon({"--speed", "stepped", "--set", "memory.max_mb=300"});
  RawWebClient client(daemon.port("web"));
  const std::string metrics = client.request("GET /metrics HTTP/1.1");
  EXPECT_NE(metrics.find("aprsim_memory_limit_bytes{part=\"total\"} 314572800"), std::string::npos);
  for (const char* part : {"journal", "history", "saved_states", "clients"}) {
    EXPECT_NE(metrics.find("aprsim_memory_limit_bytes{part=\"" + std::string(part) + "\"}"),
              std::string::npos)
        << part;
  }
  for (const char* part :
       {"journal", "journal_queues", "history", "past_states", "saved_states", "events"}) {
    EXPECT_NE(metrics.find("aprsim_memory_used_bytes{part=\"" + std::string(part) + "\"}"),
              std::string::npos)
        << part;
  }
}

}  // namespace
}  // namespace aprsim::test
