#include "protocols/crcl/crcl_server.hpp"

#include <exception>
#include <map>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <spdlog/spdlog.h>

#include "crcl/xml_tree.hpp"
#include "protocols/crcl/crcl_connection.hpp"
#include "protocols/crcl/robot_link.hpp"
#include "protocols/tcp_listener.hpp"

namespace aprsim::protocols {

namespace asio = boost::asio;

namespace {

constexpr auto kProgramPeriod = std::chrono::milliseconds(1);

RobotLinkOptions link_options(const CrclServerOptions& options) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  RobotLinkOptions link;
  link.robot = options.robot;
  link.endpoint = options.endpoint;
  link.clamp_targets = options.clamp_targets;
  link.cartesian_min_R = options.cartesian_min_R;
  link.cartesian_max_R = options.cartesian_max_R;
  link.max_program_bytes = options.max_program_bytes;
  link.start_ms = std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
  return link;
}

}  // namespace

class CrclServer::Impl {
 public:
  Impl(CrclServerOptions options, api::CommandSink& sink, const api::SnapshotSource& source)
      : options_(std::move(options)),
        link_(link_options(options_), sink, source),
        listener_(io_,
                  {link_.name(), options_.bind_address, options_.port, options_.max_connections},
                  [this](TcpListener::Socket socket, std::string peer) {
                    take(std::move(socket), std::move(peer));
                  }),
        program_timer_(io_),
        drain_timer_(io_),
        work_(io_.get_executor()) {
    crcl::initialize_xml();
    link_.on_program([this] { follow_program(); });
  }

  ~Impl() { stop(); }

  Result<std::uint16_t> start() {
    const Result<std::uint16_t> port = listener_.listen();
    if (!port) return port;
    spdlog::info("{}: listening on {} port {}", link_.name(), options_.bind_address, *port);
    thread_ = std::jthread([this] { run(); });
    return port;
  }

  void stop() {
    if (!thread_.joinable()) return;
    asio::post(io_, [this] { drain(); });
    thread_.join();
  }

  [[nodiscard]] CrclServerStats stats() const {
    return {listener_.accepted(), listener_.refused(), counters_.dropped,
            listener_.open(),     counters_.commands,  counters_.statuses};
  }

 private:
  // A handler that throws costs its connection at most; the others must go on.
  void run() {
    while (true) {
      try {
        io_.run();
        return;
      } catch (const std::exception& problem) {
        spdlog::error("{}: {}", link_.name(), problem.what());
      }
    }
  }

  void take(TcpListener::Socket socket, std::string peer) {
    const auto connection =
        std::make_shared<CrclConnection>(std::move(socket), std::move(peer), options_, link_,
                                         counters_, [this](CrclConnection& ended) {
                                           connections_.erase(&ended);
                                           listener_.release();
                                           finish_if_drained();
                                         });
    connections_[connection.get()] = connection;
    connection->start();
  }

  // A program goes on though no client asks for anything.
  void follow_program() {
    program_timer_.expires_after(kProgramPeriod);
    program_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (cancelled || draining_) return;
      link_.advance();
      if (link_.runs_program()) follow_program();
    });
  }

  void drain() {
    draining_ = true;
    program_timer_.cancel();
    listener_.close();
    for_each([](CrclConnection& connection) { connection.drain(); });
    drain_timer_.expires_after(options_.drain_deadline);
    drain_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) for_each([](CrclConnection& connection) { connection.close(); });
    });
    finish_if_drained();
  }

  // A connection may end, and leave the map, while it is visited.
  template <typename Visit>
  void for_each(const Visit& visit) {
    std::vector<std::shared_ptr<CrclConnection>> all;
    for (const auto& [key, connection] : connections_) all.push_back(connection);
    for (const auto& connection : all) visit(*connection);
  }

  void finish_if_drained() {
    if (!draining_ || !connections_.empty()) return;
    drain_timer_.cancel();
    work_.reset();
  }

  CrclServerOptions options_;
  asio::io_context io_{1};
  RobotLink link_;
  CrclCounters counters_;
  TcpListener listener_;
  std::map<CrclConnection*, std::shared_ptr<CrclConnection>> connections_;
  asio::steady_timer program_timer_, drain_timer_;
  asio::executor_work_guard<asio::io_context::executor_type> work_;
  bool draining_ = false;
  std::jthread thread_;
};

CrclServer::CrclServer(CrclServerOptions options, api::CommandSink& sink,
                       const api::SnapshotSource& source)
    : impl_(std::make_unique<Impl>(std::move(options), sink, source)) {}

CrclServer::~CrclServer() = default;

Result<std::uint16_t> CrclServer::start() { return impl_->start(); }

void CrclServer::stop() { impl_->stop(); }

CrclServerStats CrclServer::stats() const { return impl_->stats(); }

}  // namespace aprsim::protocols
