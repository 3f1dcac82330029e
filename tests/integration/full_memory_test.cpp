// All that a daemon keeps and all that its clients make it keep at once: below memory.max_mb.

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "aprsim/v1/history_service.grpc.pb.h"
#include "aprsim/v1/journal_service.grpc.pb.h"
#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/http2_frames.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/raw_web_client.hpp"
#include "tests/support/resident_memory.hpp"
#include "tests/support/tcp_socket.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

/// The highest resident memory of a process while this exists.
class MemoryPeak {
 public:
  explicit MemoryPeak(pid_t pid) {
    thread_ = std::jthread([this, pid](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        const double now = resident_mb(pid);
        if (now > peak_mb_) peak_mb_ = now;
        std::this_thread::sleep_for(2ms);  // as often as it is measured
      }
    });
  }
  [[nodiscard]] double mb() const { return peak_mb_; }

 private:
  std::atomic<double> peak_mb_{0};
  std::jthread thread_;
};

/// Clients that fill one part of a daemon's memory each, and stay.
class Besiegers {
 public:
  explicit Besiegers(const DaemonProcess& daemon) : daemon_(daemon), cell_(daemon.port("grpc")) {}

  /// A number of /metrics [MB].
  double metric_mb(const std::string& name, const std::string& part) {
    const std::string text = RawWebClient(daemon_.port("web")).request("GET /metrics HTTP/1.1");
    const std::string key = "\n" + name + "{part=\"" + part + "\"} ";
    const auto at = text.find(key);
    if (at == std::string::npos) throw std::runtime_error("no " + key + " in " + text);
    return std::stod(text.substr(at + key.size())) / (1 << 20);
  }
  bool is_full(const std::string& part) {
    return metric_mb("aprsim_memory_used_bytes", part) >
           0.8 * metric_mb("aprsim_memory_limit_bytes", part);
  }

  /// Long moves fill the journal with their documents and the history with their waypoints.
  void fill_past() {
    CrclTextClient robot(daemon_.port("crcl.fanuc"));
    robot.send("InitCanonType");
    cell_.step(50);
    const auto end = std::chrono::steady_clock::now() + kPatience * 120s;
    for (int i = 0; !is_full("journal") || !is_full("history"); ++i) {
      for (int k = 0; k < 20; ++k) robot.send("MoveThroughToType", waypoints());
      cell_.step(200);
      (void)robot.status();
      ASSERT_LT(std::chrono::steady_clock::now(), end) << "the past does not fill";
    }
  }

  void fill_states() {
    for (int i = 0; i < 1000; ++i) {
      v1::SaveStateRequest request;
      request.set_name("state_" + std::to_string(i));
      v1::SaveStateResponse response;
      grpc::ClientContext context;
      if (!cell_.control->SaveState(&context, request, &response).ok()) return;
    }
  }

  /// Files that are begun and not ended.
  void begin_uploads(int count) {
    for (int i = 0; i < count; ++i) {
      auto& upload = uploads_.emplace_back(std::make_unique<Upload>());
      upload->stub = v1::ControlService::NewStub(channel());
      upload->writer = upload->stub->ImportState(&upload->context, &upload->response);
      v1::ImportStateRequest request;
      request.set_data(std::string(30'000, 'x'));
      for (int k = 0; k < 260 && upload->writer->Write(request); ++k) {
      }
    }
  }

  /// Calls whose answers the client's window keeps at the server (RFC 9113, section 6.9).
  void ask_and_read_nothing(int connections, const std::string& method,
                            const std::string& message) {
    for (int i = 0; i < connections; ++i) {
      TcpSocket& socket = sockets_.emplace_back(daemon_.port("grpc"));
      std::string bytes = http2::kPreface +
                          http2::frame(http2::kSettings, 0, 0, std::string_view("\0\4\0\0\0\0", 6));
      for (std::uint32_t stream = 1; stream < 60; stream += 2) {
        bytes +=
            http2::frame(http2::kHeaders, http2::kEndHeaders, stream, http2::call_headers(method)) +
            http2::frame(http2::kData, http2::kEndStream, stream,
                         std::string("\0\0\0\0", 4) + static_cast<char>(message.size()) + message);
      }
      (void)socket.send(bytes);
    }
  }

  void stream_and_read_nothing(int count) {
    for (int i = 0; i < count; ++i) {
      auto& stream = streams_.emplace_back(std::make_unique<Stream>());
      stream->stub = v1::TelemetryService::NewStub(channel());
      v1::StreamSnapshotsRequest request;
      request.set_every_step(true);
      stream->reader = stream->stub->StreamSnapshots(&stream->context, request);
    }
    for (int i = 0; i < 40; ++i) cell_.step(100);
  }

  void fetch_incidents_and_read_nothing(int count) {
    for (int i = 0; i < count; ++i) {
      auto& incident = incidents_.emplace_back(std::make_unique<Incident>());
      incident->stub = v1::JournalService::NewStub(channel());
      v1::GetIncidentRequest request;
      request.mutable_last()->set_seconds(36'000);
      incident->reader = incident->stub->GetIncident(&incident->context, request);
      incident->reader->WaitForInitialMetadata();
    }
  }

  /// Documents that are never complete, and statuses that nobody reads.
  void send_documents(int connections) {
    const std::string begun = "<CRCLProgram>" + std::string(900'000, ' ');
    std::string polls;
    for (int i = 0; i < 200; ++i) polls += CrclTextClient::document("GetStatusType", 1);
    for (const char* robot : {"crcl.fanuc", "crcl.motoman"}) {
      for (int i = 0; i < connections; ++i) {
        for (const std::string& bytes : {begun, polls}) {
          // It may be closed in favour of others.
          TcpSocket& socket = sockets_.emplace_back(daemon_.port(robot), 4096);
          (void)socket.send(bytes, 200ms);
        }
      }
    }
  }

  /// Pages that ask for moments of the past and read none.
  void open_pages(int count, int requests) {
    v1::GetHistoryResponse history;
    grpc::ClientContext context;
    const auto stub = v1::HistoryService::NewStub(channel());
    CellClient::require(stub->GetHistory(&context, {}, &history));
    ASSERT_GT(history.spans_size(), 0);
    for (int i = 0; i < count; ++i) {
      pages_.emplace_back(std::make_unique<RawWebClient>(daemon_.port("web")))->upgrade();
    }
    for (int i = 0; i < requests; ++i) {
      for (const auto& page : pages_) {
        v1::ViewerRequest request;
        request.set_id(static_cast<std::uint32_t>(i + 1));
        request.mutable_past()->set_epoch(history.spans(0).epoch());
        request.mutable_past()->set_step(history.spans(0).last_step());
        page->send(request);
      }
      cell_.step(1);
    }
  }

  CellClient& cell() { return cell_; }

 private:
  template <typename Service, typename Reader>
  struct Call {
    grpc::ClientContext context;
    std::unique_ptr<typename Service::Stub> stub;
    std::unique_ptr<Reader> reader;
  };
  struct Upload {
    grpc::ClientContext context;
    v1::ImportStateResponse response;
    std::unique_ptr<v1::ControlService::Stub> stub;
    std::unique_ptr<grpc::ClientWriter<v1::ImportStateRequest>> writer;
  };
  using Stream = Call<v1::TelemetryService, grpc::ClientReader<v1::StreamSnapshotsResponse>>;
  using Incident = Call<v1::JournalService, grpc::ClientReader<v1::GetIncidentResponse>>;

  /// A connection of its own.
  [[nodiscard]] std::shared_ptr<grpc::Channel> channel() const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(daemon_.port("grpc")),
                                     grpc::InsecureChannelCredentials(), arguments);
  }

  /// Random, so that a compressed journal grows with them; below 64 kB.
  std::string waypoints() {
    constexpr int kCount = 200;
    std::uniform_real_distribution<double> offset_mm(-5, 5);
    std::string points;
    for (int i = 0; i < kCount; ++i) {
      points += fmt::format(
          "<Waypoint><Point><X>{:.9f}</X><Y>{:.9f}</Y><Z>{:.9f}</Z></Point><XAxis><I>1</I><J>0</J>"
          "<K>0</K></XAxis><ZAxis><I>0</I><J>0</J><K>-1</K></ZAxis></Waypoint>",
          385 + offset_mm(numbers_), offset_mm(numbers_), 413 + offset_mm(numbers_));
    }
    return fmt::format("<MoveStraight>false</MoveStraight>{}<NumPositions>{}</NumPositions>",
                       points, kCount);
  }

  const DaemonProcess& daemon_;
  CellClient cell_;
  std::mt19937_64 numbers_{1};
  std::vector<std::unique_ptr<Upload>> uploads_;
  std::vector<std::unique_ptr<Stream>> streams_;
  std::vector<std::unique_ptr<Incident>> incidents_;
  std::vector<TcpSocket> sockets_;
  std::vector<std::unique_ptr<RawWebClient>> pages_;
};

class FullMemory : public ::testing::TestWithParam<int> {};

TEST_P(FullMemory, StaysBelowItsLimit) {
  if (kSanitized) GTEST_SKIP() << "sanitizers take memory of their own";
  const int limit_mb = GetParam();
  DaemonProcess daemon({"--speed", "stepped", "--set", "connections.per_address=256", "--set",
                        "history.minutes=600", "--set", "journal.memory_minutes=600", "--set",
                        fmt::format("memory.max_mb={}", limit_mb)});
  const MemoryPeak peak(daemon.pid());
  Besiegers clients(daemon);
  std::string course;
  const auto note = [&](const char* part) {
    course += fmt::format("{}: {:.0f} MB; ", part, resident_mb(daemon.pid()));
  };
  note("start");
  clients.fill_past();
  note("past");
  clients.fill_states();
  note("states");
  clients.fetch_incidents_and_read_nothing(4);
  clients.begin_uploads(6);
  note("uploads");
  clients.ask_and_read_nothing(10, "/aprsim.v1.ControlService/ExportState", "\x0a\x07state_0");
  clients.ask_and_read_nothing(10, "/aprsim.v1.TelemetryService/GetScene", "");
  note("answers");
  clients.stream_and_read_nothing(24);
  note("streams");
  clients.send_documents(20);
  note("documents");
  clients.open_pages(20, 300);
  note("pages");
  clients.fill_past();
  note("past again");
  EXPECT_LT(peak.mb(), limit_mb) << course;
  std::cout << course << fmt::format("peak {:.0f} of {} MB\n", peak.mb(), limit_mb);
  // It serves a client that does nothing wrong.
  EXPECT_GT(clients.cell().snapshot().step(), 0U);
  EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
}

INSTANTIATE_TEST_SUITE_P(Limits, FullMemory, ::testing::Values(192, 300, 400),
                         [](const auto& limit) { return std::to_string(limit.param) + "MB"; });

}  // namespace
}  // namespace aprsim::test
