#include "protocols/modbus/modbus_server.hpp"

#include <exception>
#include <map>
#include <thread>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/modbus/allow_list.hpp"
#include "protocols/modbus/connection.hpp"
#include "protocols/tcp_listener.hpp"

namespace aprsim::protocols {
namespace {

using boost::system::error_code;

constexpr std::chrono::milliseconds kApplyPoll{1};

}  // namespace

class ModbusServer::Impl {
 public:
  Impl(ModbusServerOptions options, api::CommandSink& sink, const api::SnapshotSource& source)
      : options_(std::move(options)),
        sink_(sink),
        source_(source),
        listener_(io_,
                  {"modbus", options_.bind_address, options_.port, options_.max_connections,
                   [this](const boost::asio::ip::address& peer) { return allow_.allows(peer); }},
                  [this](TcpListener::Socket socket, std::string peer) {
                    take(std::move(socket), std::move(peer));
                  }) {}
  ~Impl() { stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<std::uint16_t> start();
  void stop();
  [[nodiscard]] ModbusServerStats stats() const;

 private:
  void run();
  void take(TcpListener::Socket socket, std::string peer);
  void await_applied(std::shared_ptr<Connection> connection);
  void poll_applied();
  void begin_drain();
  void close_all(std::string_view why);
  void finish_if_drained();

  const ModbusServerOptions options_;
  api::CommandSink& sink_;
  const api::SnapshotSource& source_;
  Counters counters_;

  // Everything from here on belongs to the listener's thread while it runs.
  LimitedLog log_;
  boost::asio::io_context io_{1};
  AllowList allow_;
  TcpListener listener_;
  boost::asio::steady_timer apply_timer_{io_}, drain_timer_{io_};
  std::unique_ptr<Plc> plc_;
  std::unique_ptr<ReplyBuilder> replies_;
  std::unique_ptr<ListenerContext> context_;
  std::map<const Connection*, std::shared_ptr<Connection>> connections_;
  std::vector<std::shared_ptr<Connection>> waiting_;
  bool draining_ = false;

  std::thread thread_;
};

Result<std::uint16_t> ModbusServer::Impl::start() {
  if (context_) return fail(ErrorCode::kFailedPrecondition, "modbus", "already started");
  if (const auto problem = modbus::check(options_.scaling)) {
    return fail(ErrorCode::kInvalidArgument, "modbus.full_scale_m_s", *problem);
  }
  auto allow = AllowList::from(options_.allow);
  if (!allow) return tl::unexpected(allow.error());
  allow_ = std::move(*allow);
  auto replies = ReplyBuilder::create();
  if (!replies) return tl::unexpected(replies.error());
  const auto port = listener_.listen();
  if (!port) return port;
  replies_ = std::make_unique<ReplyBuilder>(std::move(*replies));
  plc_ = std::make_unique<Plc>(options_.scaling, options_.endpoint, sink_, source_,
                               std::chrono::duration<double>(options_.watchdog).count());
  context_ = std::make_unique<ListenerContext>(
      ListenerContext{io_, options_, *plc_, *replies_, log_, counters_,
                      modbus::GateRules{options_.read_only, options_.unit_ids},
                      [this](std::shared_ptr<Connection> c) { await_applied(std::move(c)); },
                      [this](const Connection& c) {
                        connections_.erase(&c);
                        listener_.release();
                        finish_if_drained();
                      }});
  thread_ = std::thread([this] { run(); });
  return *port;
}

void ModbusServer::Impl::run() {
  // An exception here is a broken invariant or exhausted memory on behalf of one handler. The other
  // clients keep their service.
  for (;;) {
    try {
      io_.run();
      return;
    } catch (const std::exception& error) {
      log_.warn(std::string("internal error: ") + error.what());
    }
  }
}

void ModbusServer::Impl::take(TcpListener::Socket socket, std::string peer) {
  auto connection = std::make_shared<Connection>(std::move(socket), std::move(peer), *context_);
  connections_.emplace(connection.get(), connection);
  connection->start();
}

void ModbusServer::Impl::await_applied(std::shared_ptr<Connection> connection) {
  waiting_.push_back(std::move(connection));
  if (waiting_.size() > 1) return;
  apply_timer_.expires_after(kApplyPoll);
  apply_timer_.async_wait([this](const error_code& aborted) {
    if (!aborted) poll_applied();
  });
}

void ModbusServer::Impl::poll_applied() {
  plc_->refresh();
  // Whoever begins to wait meanwhile joins the new list.
  for (auto& connection : std::exchange(waiting_, {})) {
    if (connection->poll_applied(Connection::Clock::now())) await_applied(std::move(connection));
  }
}

void ModbusServer::Impl::begin_drain() {
  draining_ = true;
  listener_.close();
  drain_timer_.expires_after(options_.drain_deadline);
  drain_timer_.async_wait([this](const error_code& aborted) {
    if (!aborted) close_all("the server stops");
  });
  const auto connections = connections_;
  for (const auto& [key, connection] : connections) connection->drain();
  finish_if_drained();
}

void ModbusServer::Impl::close_all(std::string_view why) {
  const auto connections = connections_;
  for (const auto& [key, connection] : connections) connection->close(why, false);
}

void ModbusServer::Impl::finish_if_drained() {
  if (!draining_ || !connections_.empty()) return;
  waiting_.clear();
  apply_timer_.cancel();
  drain_timer_.cancel();
}

void ModbusServer::Impl::stop() {
  if (!thread_.joinable()) return;
  boost::asio::post(io_, [this] { begin_drain(); });
  thread_.join();
}

ModbusServerStats ModbusServer::Impl::stats() const {
  ModbusServerStats stats;
  stats.accepted = listener_.accepted();
  stats.refused = listener_.refused();
  stats.dropped = counters_.dropped;
  stats.open = listener_.open();
  stats.requests = counters_.requests;
  stats.exceptions = counters_.exceptions;
  return stats;
}

ModbusServer::ModbusServer(ModbusServerOptions options, api::CommandSink& sink,
                           const api::SnapshotSource& source)
    : impl_(std::make_unique<Impl>(std::move(options), sink, source)) {}
ModbusServer::~ModbusServer() = default;
Result<std::uint16_t> ModbusServer::start() { return impl_->start(); }
void ModbusServer::stop() { impl_->stop(); }
ModbusServerStats ModbusServer::stats() const { return impl_->stats(); }

}  // namespace aprsim::protocols
