#include "protocols/modbus/modbus_server.hpp"

#include <exception>
#include <map>
#include <thread>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "protocols/modbus/allow_list.hpp"
#include "protocols/modbus/connection.hpp"

namespace aprsim::protocols {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr std::chrono::milliseconds kApplyPoll{1};
constexpr std::chrono::milliseconds kAcceptRetry{100};
constexpr int kAcceptsPerTurn = 32;

std::string text(const tcp::endpoint& endpoint) {
  const std::string address = endpoint.address().to_string();
  const std::string port = std::to_string(endpoint.port());
  return endpoint.address().is_v6() ? "[" + address + "]:" + port : address + ":" + port;
}

}  // namespace

class ModbusServer::Impl {
 public:
  Impl(ModbusServerOptions options, api::CommandSink& sink, const api::SnapshotSource& source)
      : options_(std::move(options)), sink_(sink), source_(source) {}
  ~Impl() { stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<std::uint16_t> start();
  void stop();
  [[nodiscard]] ModbusServerStats stats() const;

 private:
  Result<std::uint16_t> listen();
  void run();
  void accept();
  void accept_waiting();
  void take(tcp::socket socket);
  [[nodiscard]] std::string refusal(const tcp::endpoint& peer) const;
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
  tcp::acceptor acceptor_{io_};
  boost::asio::steady_timer retry_timer_{io_}, apply_timer_{io_}, drain_timer_{io_};
  AllowList allow_;
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
  const auto port = listen();
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
                        counters_.open = connections_.size();
                        finish_if_drained();
                      }});
  accept();
  thread_ = std::thread([this] { run(); });
  return *port;
}

Result<std::uint16_t> ModbusServer::Impl::listen() {
  const auto failed = [this](const error_code& error) {
    error_code ignored;
    acceptor_.close(ignored);
    return fail(ErrorCode::kUnavailable, "modbus.port",
                "cannot listen on " + options_.bind_address + " port " +
                    std::to_string(options_.port) + ": " + error.message());
  };
  error_code error;
  const auto address = boost::asio::ip::make_address(options_.bind_address, error);
  if (error) {
    return fail(ErrorCode::kInvalidArgument, "modbus.bind_address",
                "'" + options_.bind_address + "' is not a numeric IPv4 or IPv6 address");
  }
  const tcp::endpoint endpoint(address, options_.port);
  acceptor_.open(endpoint.protocol(), error);
  if (error) return failed(error);
  acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
  if (error) return failed(error);
  acceptor_.bind(endpoint, error);
  if (error) return failed(error);
  acceptor_.listen(boost::asio::socket_base::max_listen_connections, error);
  if (error) return failed(error);
  acceptor_.non_blocking(true, error);
  if (error) return failed(error);
  const tcp::endpoint local = acceptor_.local_endpoint(error);
  if (error) return failed(error);
  return local.port();
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

void ModbusServer::Impl::accept() {
  acceptor_.async_wait(tcp::acceptor::wait_read, [this](const error_code& aborted) {
    if (!aborted && acceptor_.is_open()) accept_waiting();
  });
}

void ModbusServer::Impl::accept_waiting() {
  // Several a turn: otherwise a newcomer behind many others would wait for as many turns.
  for (int i = 0; i < kAcceptsPerTurn; ++i) {
    tcp::socket socket(io_);
    error_code error;
    acceptor_.accept(socket, error);
    if (error == boost::asio::error::would_block) break;
    if (error == boost::asio::error::connection_aborted) continue;
    if (error) {
      // Out of descriptors or memory: that passes, and must not end the listening.
      log_.warn("cannot accept a connection: " + error.message());
      retry_timer_.expires_after(kAcceptRetry);
      retry_timer_.async_wait([this](const error_code& aborted) {
        if (!aborted && acceptor_.is_open()) accept();
      });
      return;
    }
    take(std::move(socket));
  }
  accept();
}

void ModbusServer::Impl::take(tcp::socket socket) {
  error_code gone;
  const tcp::endpoint peer = socket.remote_endpoint(gone);
  if (gone) return;
  if (const std::string why = refusal(peer); !why.empty()) {
    ++counters_.refused;
    log_.warn(text(peer) + " refused: " + why);
    return;
  }
  ++counters_.accepted;
  auto connection = std::make_shared<Connection>(std::move(socket), text(peer), *context_);
  connections_.emplace(connection.get(), connection);
  counters_.open = connections_.size();
  connection->start();
}

std::string ModbusServer::Impl::refusal(const tcp::endpoint& peer) const {
  if (!allow_.allows(peer.address())) return "its address is not on the allow list";
  if (connections_.size() < options_.max_connections) return {};
  return std::to_string(options_.max_connections) + " connections are open, which is the limit";
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
  error_code ignored;
  acceptor_.close(ignored);
  retry_timer_.cancel();
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
  stats.accepted = counters_.accepted;
  stats.refused = counters_.refused;
  stats.dropped = counters_.dropped;
  stats.open = counters_.open;
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
