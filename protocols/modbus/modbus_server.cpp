#include "protocols/modbus/modbus_server.hpp"

#include <utility>

#include "protocols/modbus/banks/conveyor_bank.hpp"
#include "protocols/modbus/banks/map_bank.hpp"
#include "protocols/modbus/connection.hpp"
#include "protocols/net/tcp_service.hpp"
#include "protocols/ports/wire_faults.hpp"

namespace aprsim::modbus_server {
namespace {

using boost::system::error_code;

constexpr std::chrono::milliseconds kApplyPoll{1};
/// Period of checking snapshots for injected faults that close the port.
constexpr std::chrono::milliseconds kFaultPeriod{10};

}  // namespace

std::string listener_name(const ModbusServerOptions& options) {
  const std::string wire = options.listener.tls ? "modbus_tls" : "modbus";
  return options.map.empty() ? wire : wire + "." + options.map;
}

class ModbusServer::Impl {
 public:
  Impl(ModbusServerOptions options, api::CommandSink& sink, const api::SnapshotSource& source)
      : options_(std::move(options)),
        sink_(sink),
        source_(source),
        main_(options_),
        service_(listener_name(options_), options_.listener, maker(main_)) {
    if (!options_.secure) return;
    ModbusServerOptions secure = options_;
    secure.listener = *options_.secure;
    secure_ = std::make_unique<Port>(std::move(secure));
    secure_listener_ =
        &service_.add(listener_name(secure_->options), secure_->options.listener, maker(*secure_));
  }
  ~Impl() { stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<std::uint16_t> start();
  void stop();
  [[nodiscard]] std::uint16_t secure_port() const { return secure_port_; }
  [[nodiscard]] ModbusServerStats stats() const { return stats_of(main_, service_.listener()); }
  [[nodiscard]] std::optional<ModbusServerStats> secure_stats() const {
    if (!secure_) return std::nullopt;
    return stats_of(*secure_, *secure_listener_);
  }

 private:
  /// The parts of one port; the context exists from start() on.
  struct Port {
    explicit Port(ModbusServerOptions of) : options(std::move(of)), log(listener_name(options)) {}
    const ModbusServerOptions options;
    Counters counters;
    protocols::LimitedLog log;
    std::unique_ptr<ListenerContext> context;
  };

  [[nodiscard]] static ModbusServerStats stats_of(const Port& port,
                                                  const protocols::TcpListener& listener);
  [[nodiscard]] static protocols::TcpService<Connection>::Make maker(Port& port) {
    return [&port](protocols::TcpListener::Socket socket, std::string peer,
                   protocols::TcpListener::Slot slot) {
      return std::make_shared<Connection>(std::move(socket), std::move(peer), std::move(slot),
                                          *port.context);
    };
  }
  void make_context(Port& port);
  [[nodiscard]] std::unique_ptr<RegisterBank> make_bank();
  void await_applied(std::shared_ptr<Connection> connection);
  void poll_applied();
  void end(Connection& connection);
  void watch_faults();

  const ModbusServerOptions options_;
  api::CommandSink& sink_;
  const api::SnapshotSource& source_;

  // The following belongs to the listener's thread while it runs.
  Port main_;
  std::unique_ptr<Port> secure_;  // null = there is none
  protocols::TcpService<Connection> service_;
  protocols::TcpListener* secure_listener_ = nullptr;
  std::uint16_t secure_port_ = 0;
  boost::asio::steady_timer apply_timer_{service_.io()}, fault_timer_{service_.io()};
  HandshakePace handshakes_{service_.io().get_executor()};
  bool closed_ = false;  // the ports, by an injected fault
  std::unique_ptr<RegisterBank> bank_;
  std::unique_ptr<ReplyBuilder> replies_;
  std::vector<std::shared_ptr<Connection>> waiting_;
};

Result<std::uint16_t> ModbusServer::Impl::start() {
  if (bank_) return fail(ErrorCode::kFailedPrecondition, "modbus", "already started");
  if (const auto problem = modbus::check(options_.scaling)) {
    return fail(ErrorCode::kInvalidArgument, "modbus.full_scale_m_s", *problem);
  }
  auto replies = ReplyBuilder::create();
  if (!replies) return tl::unexpected(replies.error());
  const auto port = service_.listen();
  if (!port) return port;
  if (secure_listener_ != nullptr) {
    const auto secure = secure_listener_->listen();
    if (!secure) return secure;
    secure_port_ = *secure;
  }
  replies_ = std::make_unique<ReplyBuilder>(std::move(*replies));
  bank_ = make_bank();
  make_context(main_);
  if (secure_) make_context(*secure_);
  watch_faults();
  service_.start();
  return *port;
}

void ModbusServer::Impl::make_context(Port& port) {
  port.context = std::make_unique<ListenerContext>(ListenerContext{
      service_.io(), port.options, *bank_, *replies_, port.log, port.counters, handshakes_,
      modbus::RequestRules{options_.read_only, options_.unit_ids, bank_->addresses()}, source_,
      [this](std::shared_ptr<Connection> c) { await_applied(std::move(c)); },
      [this](Connection& c) { end(c); }});
}

std::unique_ptr<RegisterBank> ModbusServer::Impl::make_bank() {
  const api::EndpointId endpoint = options_.listener.endpoint;
  if (!options_.map.empty()) {
    return std::make_unique<MapBank>(options_.map, endpoint, sink_, source_);
  }
  return std::make_unique<ConveyorBank>(options_.scaling, endpoint, sink_, source_,
                                        std::chrono::duration<double>(options_.watchdog).count());
}

void ModbusServer::Impl::watch_faults() {
  fault_timer_.expires_after(kFaultPeriod);
  fault_timer_.async_wait([this](const error_code& aborted) {
    if (!aborted && !service_.draining()) watch_faults();
  });
  const bool closed = protocols::injected(*source_.latest(), faults::Kind::kModbusRefused);
  if (closed == closed_) return;
  closed_ = closed;
  service_.refuse_connections(closed);
  if (!closed) return;
  service_.for_each([](Connection& connection) { connection.close("an injected fault", true); });
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
  bank_->refresh();
  // Connections that begin to wait meanwhile join the new list.
  for (auto& connection : std::exchange(waiting_, {})) {
    if (connection->poll_applied(Connection::Clock::now())) await_applied(std::move(connection));
  }
}

void ModbusServer::Impl::end(Connection& connection) {
  std::erase_if(waiting_, [&](const auto& waits) { return waits.get() == &connection; });
  service_.ended(connection);
}

void ModbusServer::Impl::stop() {
  service_.stop([this] { fault_timer_.cancel(); });
}

ModbusServerStats ModbusServer::Impl::stats_of(const Port& port,
                                               const protocols::TcpListener& listener) {
  ModbusServerStats stats;
  stats.accepted = listener.accepted();
  stats.refused = listener.refused();
  stats.dropped = port.counters.dropped;
  stats.open = listener.open();
  stats.requests = port.counters.requests;
  stats.exceptions = port.counters.exceptions;
  stats.answer_times = port.counters.answer_times.counts();
  return stats;
}

ModbusServer::ModbusServer(ModbusServerOptions options, api::CommandSink& sink,
                           const api::SnapshotSource& source)
    : impl_(std::make_unique<Impl>(std::move(options), sink, source)) {}
ModbusServer::~ModbusServer() = default;
Result<std::uint16_t> ModbusServer::start() { return impl_->start(); }
void ModbusServer::stop() { impl_->stop(); }
std::uint16_t ModbusServer::secure_port() const { return impl_->secure_port(); }
ModbusServerStats ModbusServer::stats() const { return impl_->stats(); }
std::optional<ModbusServerStats> ModbusServer::secure_stats() const {
  return impl_->secure_stats();
}

}  // namespace aprsim::modbus_server
