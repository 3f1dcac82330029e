#include "protocols/grpc/grpc_server.hpp"

#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <grpc/compression.h>
#include <grpc/support/log.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <spdlog/spdlog.h>

#include "protocols/grpc/calls/call_counter.hpp"
#include "protocols/grpc/calls/call_gate.hpp"
#include "protocols/grpc/calls/call_trace.hpp"
#include "protocols/grpc/calls/command_waiter.hpp"
#include "protocols/grpc/calls/connected_clients.hpp"
#include "protocols/grpc/calls/unread_answers.hpp"
#include "protocols/grpc/http2/backoff.hpp"
#include "protocols/grpc/http2/http2_relay.hpp"
#include "protocols/grpc/services/camera_service.hpp"
#include "protocols/grpc/services/control_service.hpp"
#include "protocols/grpc/services/history_service.hpp"
#include "protocols/grpc/services/journal_service.hpp"
#include "protocols/grpc/services/robot_service.hpp"
#include "protocols/grpc/services/telemetry_service.hpp"
#include "protocols/grpc/services/trajectory_service.hpp"
#include "protocols/grpc/streams/event_stream.hpp"
#include "protocols/grpc/streams/image_hub.hpp"
#include "protocols/grpc/streams/stream_hub.hpp"
#include "protocols/net/limited_log.hpp"
#include "protocols/net/tcp_service.hpp"

namespace aprsim::grpc_server {
namespace {

/// The text of a scene may have 1 MiB, like its file.
constexpr int kMaxMessageBytes = (1 << 20) + 64 * 1024;

/// Identifies this process among all that ever ran.
std::string random_instance_id() {
  std::random_device device;
  std::string id;
  for (int i = 0; i < 4; ++i) id += fmt::format("{:08x}", device());
  return id;
}

Result<void> check(const TelemetryOptions& options) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!positive(options.max_rate_hz) || options.max_rate_hz > 1e4) {
    return fail(ErrorCode::kInvalidArgument, "grpc.max_rate_hz",
                fmt::format("{} is not above 0 and up to 10000 Hz", options.max_rate_hz));
  }
  if (!positive(options.default_rate_hz) || options.default_rate_hz > options.max_rate_hz) {
    return fail(ErrorCode::kInvalidArgument, "grpc.default_rate_hz",
                fmt::format("{} is not above 0 and up to the maximum of {} Hz",
                            options.default_rate_hz, options.max_rate_hz));
  }
  if (options.max_streams < 1 || options.max_event_streams < 1 ||
      options.listener.limits.at_once < 1) {
    return fail(ErrorCode::kInvalidArgument, "grpc",
                fmt::format("max_streams {}, max_event_streams {} and max_connections {} must be "
                            "at least 1",
                            options.max_streams, options.max_event_streams,
                            options.listener.limits.at_once));
  }
  return {};
}

void set_limits(grpc::ServerBuilder& builder, std::size_t max_memory_bytes) {
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  // gRPC unpacks a message before it applies the limit, so compressed ones are refused.
  for (const auto algorithm : {GRPC_COMPRESS_DEFLATE, GRPC_COMPRESS_GZIP}) {
    builder.SetCompressionAlgorithmSupportStatus(algorithm, false);
  }
  builder.AddChannelArgument(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
  builder.SetResourceQuota(grpc::ResourceQuota("telemetry").Resize(max_memory_bytes));
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, 32);
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, 8 * 1024);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, 300'000);
  // Detect a dead peer within 15 s, and accept pings of clients every 5 s.
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5'000);
}

/// Logs a line of gRPC, from any of its threads, at a bounded rate.
void log_of_grpc(gpr_log_func_args* line) {
  static std::mutex mutex;
  static protocols::LimitedLog log("grpc");
  const std::lock_guard lock(mutex);
  log.warn(line->message);
}

void set_up_grpc() {
  // Settings of the whole process, before its first builder.
  static std::once_flag once;
  std::call_once(once, [] {
    gpr_set_log_function(&log_of_grpc);
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  });
}

}  // namespace

class TelemetryServer::Impl {
 public:
  Impl(TelemetryOptions options, api::CommandSink& sink, const api::SnapshotSource& source)
      : options_(std::move(options)),
        sink_(sink),
        source_(source),
        unread_(options_.max_unread_bytes, options_.write_timeout),
        unread_images_(options_.max_unread_image_bytes, options_.write_timeout) {
    if (options_.instance_id.empty()) options_.instance_id = random_instance_id();
    if (!options_.listener.access) {
      options_.listener.access = std::make_shared<protocols::Access>(protocols::AccessRules{});
    }
    gate_ = std::make_unique<CallGate>(*options_.listener.access, clients_, options_.listener.audit,
                                       options_.listener.refusals);
  }

  Result<std::uint16_t> start() {
    if (const auto ok = check(options_); !ok) return tl::unexpected(ok.error());
    service_ = std::make_unique<Service>(
        log_.name(), options_.listener,
        [this](protocols::TcpListener::Socket socket, std::string peer,
               protocols::TcpListener::Slot slot) {
          protocols::ConnectionTrace trace(options_.listener.trace, source_,
                                           protocols::WireKind::kGrpc, log_.name(), peer);
          return std::make_shared<Http2Relay>(std::move(socket), std::move(peer), std::move(slot),
                                              std::move(trace), rules_, log_, backoff_);
        });
    auto port = service_->listen();
    if (!port) {
      if (port.error().code == ErrorCode::kUnavailable) port.error().field = "grpc.port";
      return port;
    }
    hub_ = std::make_unique<StreamHub>(source_, options_.feed, options_.max_streams,
                                       options_.max_backlogs_bytes, options_.write_timeout, [this] {
                                         report_health();
                                         unread_.cancel_stuck(UnreadAnswers::Clock::now());
                                         unread_images_.cancel_stuck(UnreadAnswers::Clock::now());
                                       });
    event_hub_ = std::make_unique<EventHub>(options_.events, options_.max_event_streams,
                                            options_.write_timeout);
    trajectory_hub_ = std::make_unique<TrajectoryHub>(source_, options_.write_timeout);
    image_hub_ = std::make_unique<ImageHub>(options_.max_image_streams, options_.write_timeout);
    waiter_ = std::make_unique<CommandWaiter>(source_);
    telemetry_ = std::make_unique<TelemetryService>(options_, source_, *hub_, *event_hub_, *gate_);
    control_ = std::make_unique<ControlService>(options_, sink_, source_, *waiter_, *gate_);
    trajectories_ = std::make_unique<TrajectoryService>(options_, sink_, source_, *trajectory_hub_,
                                                        *gate_, *control_);
    history_ = std::make_unique<HistoryService>(options_, *control_);
    journal_ = std::make_unique<JournalService>(options_.incidents, *gate_);
    cameras_ = std::make_unique<CameraService>(options_.cameras, *image_hub_, *gate_);
    robots_ = std::make_unique<RobotService>(
        options_.robots,
        [this](const grpc::CallbackServerContext& context) { return control_->refusal(context); });
    if (!serve()) {
      return fail(ErrorCode::kUnavailable, "grpc", "gRPC refused to start its server");
    }
    return port;
  }

  void stop(std::chrono::milliseconds span) {
    if (!service_) return;
    const auto deadline = std::chrono::steady_clock::now() + span;
    service_->stop_accepting();
    if (waiter_) waiter_->stop();
    if (hub_) hub_->stop(deadline);
    if (event_hub_) event_hub_->stop(deadline);
    if (trajectory_hub_) trajectory_hub_->stop(deadline);
    if (image_hub_) image_hub_->stop(deadline);
    if (const auto server = detach_server()) {
      const auto left = deadline - std::chrono::steady_clock::now();
      server->Shutdown(std::chrono::system_clock::now() +
                       std::chrono::duration_cast<std::chrono::system_clock::duration>(left));
      server->Wait();
    }
    // The relays forward the last frames of gRPC.
    service_->stop();
    service_.reset();
  }

  [[nodiscard]] TelemetryStats stats() const {
    if (!service_ || !hub_) return {};
    const protocols::TcpListener& listener = service_->listener();
    const CallCounts calls = calls_.counts();
    return {.accepted = listener.accepted(),
            .refused = listener.refused(),
            .open = listener.open(),
            .calls = calls.begun,
            .failed = calls.failed,
            .streams = hub_->open(),
            .samples = hub_->counters().samples,
            .dropped = hub_->counters().dropped,
            .answer_times = calls.times};
  }

 private:
  using Service = protocols::TcpService<Http2Relay>;
  using Handover = grpc::experimental::ExternalConnectionAcceptor;

  bool serve() {
    set_up_grpc();
    grpc::ServerBuilder builder;
    set_limits(builder, options_.max_memory_bytes);
    builder.RegisterService(telemetry_.get());
    builder.RegisterService(control_.get());
    builder.RegisterService(history_.get());
    builder.RegisterService(journal_.get());
    builder.RegisterService(cameras_.get());
    builder.RegisterService(robots_.get());
    builder.RegisterService(trajectories_.get());
    // Outgoing messages pass the gate first, so that the other interceptors see refusals.
    auto interceptors = calls_.interceptors();
    interceptors.insert(interceptors.begin(), gate_->interceptor());
    const auto sends_images = [](std::string_view method) {
      return method.starts_with("/aprsim.v1.CameraService/");
    };
    interceptors.insert(interceptors.begin(), unread_images_.interceptor(sends_images));
    interceptors.insert(interceptors.begin(), unread_.interceptor([sends_images](auto method) {
      return !sends_images(method);
    }));
    if (options_.listener.trace != nullptr) {
      interceptors.push_back(trace_of_calls(*options_.listener.trace, source_));
    }
    builder.experimental().SetInterceptorCreators(std::move(interceptors));
    std::shared_ptr<Handover> handover = builder.experimental().AddExternalConnectionAcceptor(
        grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
        grpc::InsecureServerCredentials());
    std::shared_ptr<grpc::Server> server = builder.BuildAndStart();
    if (!server) return false;
    {
      const std::lock_guard lock(server_mutex_);
      server_ = std::move(server);
    }
    report_health();
    rules_.stall_timeout = 2 * options_.write_timeout;  // gRPC's streams end first
    rules_.clients = &clients_;
    rules_.tls = options_.listener.tls;
    rules_.hand_over = [handover](int fd) {
      Handover::NewConnectionParameters connection;
      connection.fd = fd;
      handover->HandleNewConnection(&connection);
    };
    rules_.on_end = [this](Http2Relay& relay) { service_->ended(relay); };
    service_->start();
    return true;
  }

  void report_health() {
    const std::lock_guard lock(server_mutex_);
    if (!server_) return;
    const std::string problem = source_.problem();
    const bool serving = problem.empty();
    if (serving_ == serving) return;
    if (!serving) spdlog::error("not serving: {}", problem);
    if (serving && serving_) spdlog::info("serving again");
    serving_ = serving;
    auto& health = *server_->GetHealthCheckService();
    for (const char* name :
         {"", v1::TelemetryService::service_full_name(), v1::ControlService::service_full_name(),
          v1::HistoryService::service_full_name(), v1::JournalService::service_full_name(),
          v1::CameraService::service_full_name(), v1::TrajectoryService::service_full_name(),
          crcl::v1::RobotService::service_full_name()}) {
      health.SetServingStatus(name, serving);
    }
  }

  std::shared_ptr<grpc::Server> detach_server() {
    const std::lock_guard lock(server_mutex_);
    return std::exchange(server_, nullptr);
  }

  TelemetryOptions options_;
  api::CommandSink& sink_;
  const api::SnapshotSource& source_;
  protocols::LimitedLog log_{"grpc"};
  RelayRules rules_;
  Backoff backoff_;
  CallCounter calls_;
  UnreadAnswers unread_, unread_images_;
  ConnectedClients clients_;
  std::unique_ptr<CallGate> gate_;
  std::unique_ptr<Service> service_;
  std::unique_ptr<StreamHub> hub_;
  std::unique_ptr<EventHub> event_hub_;
  std::unique_ptr<TrajectoryHub> trajectory_hub_;
  std::unique_ptr<ImageHub> image_hub_;
  std::unique_ptr<CommandWaiter> waiter_;
  std::unique_ptr<TelemetryService> telemetry_;
  std::unique_ptr<ControlService> control_;
  std::unique_ptr<HistoryService> history_;
  std::unique_ptr<TrajectoryService> trajectories_;
  std::unique_ptr<JournalService> journal_;
  std::unique_ptr<CameraService> cameras_;
  std::unique_ptr<RobotService> robots_;
  std::mutex server_mutex_;
  std::shared_ptr<grpc::Server> server_;
  std::optional<bool> serving_;  // what health said last; under server_mutex_
};

TelemetryServer::TelemetryServer(TelemetryOptions options, api::CommandSink& sink,
                                 const api::SnapshotSource& source)
    : impl_(std::make_unique<Impl>(std::move(options), sink, source)) {}

TelemetryServer::~TelemetryServer() { stop(); }

Result<std::uint16_t> TelemetryServer::start() { return impl_->start(); }

void TelemetryServer::stop(std::chrono::milliseconds deadline) { impl_->stop(deadline); }

TelemetryStats TelemetryServer::stats() const { return impl_->stats(); }

}  // namespace aprsim::grpc_server
