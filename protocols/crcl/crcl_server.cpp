#include "protocols/crcl/crcl_server.hpp"

#include <atomic>
#include <map>
#include <utility>

#include <spdlog/spdlog.h>

#include "crcl/xml_reader.hpp"
#include "protocols/crcl/command_executor.hpp"
#include "protocols/crcl/crcl_connection.hpp"
#include "protocols/crcl/port_session.hpp"
#include "protocols/net/tcp_service.hpp"
#include "protocols/net/time_pacer.hpp"
#include "protocols/ports/wire_faults.hpp"

namespace aprsim::crcl_server {

namespace {

constexpr auto kProgramPeriod = std::chrono::milliseconds(1);
/// Period of checking injected faults of the port, and peers that nothing is read from.
constexpr auto kFaultPeriod = std::chrono::milliseconds(10);

}  // namespace

CommandExecutorOptions executor_options(const CrclServerOptions& options) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  CommandExecutorOptions executor;
  executor.robot = options.robot;
  executor.endpoint = options.listener.endpoint;
  executor.clamp_targets = options.clamp_targets;
  executor.cartesian_min_R = options.cartesian_min_R;
  executor.cartesian_max_R = options.cartesian_max_R;
  executor.max_program_bytes = options.max_program_bytes;
  executor.end_program_with_client = options.end_program_with_client;
  executor.virtual_time = options.listener.virtual_time != nullptr;
  executor.refusals = options.listener.refusals;
  executor.start_ms = std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
  return executor;
}

class CrclServer::Impl {
 public:
  Impl(CrclServerOptions options, api::CommandSink& sink, const api::SnapshotSource& source)
      : options_(std::move(options)),
        executor_(executor_options(options_), sink, source),
        robot_(executor_.robot()),
        max_unfinished_bytes_(options_.max_unfinished_bytes),
        service_(executor_.name(), options_.listener,
                 [this](protocols::TcpListener::Socket socket, std::string peer,
                        protocols::TcpListener::Slot slot) {
                   protocols::ConnectionTrace trace(options_.listener.trace, source_,
                                                    protocols::WireKind::kCrcl, executor_.name(),
                                                    peer);
                   return std::make_shared<CrclConnection>(
                       std::move(socket), std::move(peer), std::move(slot), std::move(trace),
                       options_, executor_, counters_,
                       CrclConnection::Events{
                           .time = [this] { follow_faults(); },
                           .input = [this] { limit_input(); },
                           .end = [this](CrclConnection& ended) { service_.ended(ended); }});
                 }),
        program_timer_(service_.io()),
        fault_timer_(service_.io()),
        program_pacer_(options_.listener.virtual_time, service_.io().get_executor()),
        source_(source),
        drops_(faults::Kind::kCrclDrop, options_.robot) {
    crcl::initialize_xml();
    executor_.on_program([this] { schedule_program(); });
  }

  ~Impl() { stop(); }

  Result<std::uint16_t> start() {
    const Result<std::uint16_t> port = service_.listen();
    if (!port) return port;
    spdlog::info("{}: listening on {} port {}", executor_.name(), options_.listener.address, *port);
    watch_faults();
    service_.start();
    return port;
  }

  void stop() {
    service_.stop([this] {
      stopping_ = true;
      for_each_session([](PortSession& session) {
        session.end(ErrorCode::kUnavailable, "the robot's port closes");
      });
      program_pacer_.leave();
      program_timer_.cancel();
      fault_timer_.cancel();
    });
  }

  void set_robot(int robot, std::function<void()> change) {
    boost::asio::post(service_.io(), [this, robot, change = std::move(change)] {
      change();
      options_.robot = robot;
      executor_.set_robot(robot);
      drops_ = protocols::MomentaryFaults(faults::Kind::kCrclDrop, robot);
    });
  }

  void limit_unfinished(std::size_t bytes) { max_unfinished_bytes_ = bytes; }

  [[nodiscard]] CrclServerStats stats() const {
    const protocols::TcpListener& listener = service_.listener();
    return {listener.accepted(),
            listener.refused(),
            counters_.dropped,
            listener.open(),
            counters_.commands,
            counters_.statuses,
            counters_.answer_times.counts()};
  }

  [[nodiscard]] const std::string& robot() const { return robot_; }

  // Sessions are counted by the opening thread; the rest runs on the server's thread.
  Result<std::shared_ptr<protocols::RobotSession>> open(
      protocols::RobotSessionOptions asked, std::shared_ptr<protocols::RobotClient> client) {
    if (stopping_) return fail(ErrorCode::kUnavailable, executor_.name(), "the port is closed");
    if (++sessions_open_ > options_.listener.limits.at_once) {
      --sessions_open_;
      return fail(
          ErrorCode::kUnavailable, executor_.name(),
          fmt::format("all {} places for sessions are taken", options_.listener.limits.at_once));
    }
    asked.peer += fmt::format(" session {}", ++last_session_);
    auto session =
        std::make_shared<PortSession>(asked, std::move(client), options_, executor_, counters_,
                                      service_.io().get_executor(), [this](PortSession& ended) {
                                        --sessions_open_;
                                        sessions_.erase(&ended);
                                      });
    boost::asio::post(service_.io(), [this, session] {
      sessions_[session.get()] = session;
      if (stopping_) session->end(ErrorCode::kUnavailable, "the robot's port closes");
      if (closed_) session->end(ErrorCode::kUnavailable, "the robot's controller restarts");
    });
    return session;
  }

 private:
  template <typename Visit>
  void for_each_session(const Visit& visit) {
    const auto all = sessions_;
    for (const auto& [key, session] : all) visit(*session);
  }

  // A program continues without any request of a client.
  void schedule_program() {
    if (options_.listener.virtual_time) return ask_for_program();
    program_timer_.expires_after(kProgramPeriod);
    program_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) advance_program();
    });
  }

  void advance_program() {
    if (service_.draining()) return;
    executor_.advance();
    if (executor_.runs_program()) return schedule_program();
    program_pacer_.leave();
  }

  // In virtual time it advances at instants of the cell.
  void ask_for_program() {
    program_pacer_.join({executor_.name(), api::PacerKind::kProgram, options_.listener.endpoint});
    if (program_pacer_.joined())
      program_pacer_.after(kProgramPeriod, [this] { advance_program(); });
  }

  void limit_input() {
    std::size_t bytes = 0;
    CrclConnection* largest = nullptr;
    service_.for_each([&](CrclConnection& connection) {
      bytes += connection.unfinished_bytes();
      if (!largest || connection.unfinished_bytes() > largest->unfinished_bytes()) {
        largest = &connection;
      }
    });
    if (bytes > max_unfinished_bytes_) largest->drop_unfinished();
  }

  // A pacing client sees faults only at its own instants.
  [[nodiscard]] bool somebody_paces() {
    bool paces = false;
    service_.for_each([&](const CrclConnection& connection) { paces |= connection.paces(); });
    return paces;
  }

  void watch_faults() {
    fault_timer_.expires_after(kFaultPeriod);
    fault_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled && !service_.draining()) watch_faults();
    });
    service_.for_each([](CrclConnection& connection) { connection.notice_end(); });
    if (!options_.listener.virtual_time || !somebody_paces()) follow_faults();
  }

  // A restarting controller closes its port; a dropped connection may return at once.
  void follow_faults() {
    const api::SnapshotPtr now = source_.latest();
    if (now->faults == followed_ && now->epoch == epoch_) return;
    followed_ = now->faults;
    epoch_ = now->epoch;
    const bool drop = drops_.happened(*now);
    const bool closed = protocols::injected(*now, faults::Kind::kControllerReboot, options_.robot);
    if (closed != closed_) service_.refuse_connections(closed);
    if (closed && !closed_) {
      service_.for_each([](CrclConnection& connection) { connection.exclude(); });
      for_each_session([](PortSession& session) {
        session.end(ErrorCode::kUnavailable, "the robot's controller restarts");
      });
    } else if (drop) {
      service_.for_each([](CrclConnection& connection) { connection.break_off(); });
      for_each_session([](PortSession& session) { session.break_off(); });
    }
    closed_ = closed;
  }

  CrclServerOptions options_;
  CommandExecutor executor_;
  const std::string robot_;  // its name in the scene that the server began with
  CrclCounters counters_;
  std::atomic<std::size_t> max_unfinished_bytes_;
  std::atomic<std::size_t> sessions_open_{0};
  std::atomic<std::uint64_t> last_session_{0};
  std::atomic<bool> stopping_{false};
  std::map<const PortSession*, std::shared_ptr<PortSession>> sessions_;
  protocols::TcpService<CrclConnection> service_;
  boost::asio::steady_timer program_timer_, fault_timer_;
  protocols::TimePacer program_pacer_;  // has joined while a program runs in virtual time
  const api::SnapshotSource& source_;
  protocols::MomentaryFaults drops_;
  api::InjectedFaultsPtr followed_;  // the faults that the port has followed
  std::uint64_t epoch_ = 0;
  bool closed_ = false;  // the port, by an injected fault
};

CrclServer::CrclServer(CrclServerOptions options, api::CommandSink& sink,
                       const api::SnapshotSource& source)
    : impl_(std::make_unique<Impl>(std::move(options), sink, source)) {}

CrclServer::~CrclServer() = default;

Result<std::uint16_t> CrclServer::start() { return impl_->start(); }

void CrclServer::stop() { impl_->stop(); }

void CrclServer::set_robot(int robot, std::function<void()> change) {
  impl_->set_robot(robot, std::move(change));
}

void CrclServer::limit_unfinished(std::size_t bytes) { impl_->limit_unfinished(bytes); }

CrclServerStats CrclServer::stats() const { return impl_->stats(); }

const std::string& CrclServer::robot() const { return impl_->robot(); }

Result<std::shared_ptr<protocols::RobotSession>> CrclServer::open(
    protocols::RobotSessionOptions options, std::shared_ptr<protocols::RobotClient> client) {
  return impl_->open(std::move(options), std::move(client));
}

}  // namespace aprsim::crcl_server
