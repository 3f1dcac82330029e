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
  return options.map.empty() ? "modbus" : "modbus." + options.map;
}

class ModbusServer::Impl {
 public:
  Impl(ModbusServerOptions options, api::CommandSink& sink, const api::SnapshotSource& source)
      : options_(std::move(options)),
        sink_(sink),
        source_(source),
        log_(listener_name(options_)),
        service_(listener_name(options_), options_.listener,
                 [this](protocols::TcpListener::Socket socket, std::string peer,
                        protocols::TcpListener::Slot slot) {
                   return std::make_shared<Connection>(std::move(socket), std::move(peer),
                                                       std::move(slot), *context_);
                 }) {}
  ~Impl() { stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<std::uint16_t> start();
  void stop();
  [[nodiscard]] ModbusServerStats stats() const;

 private:
  [[nodiscard]] std::unique_ptr<RegisterBank> make_bank();
  void await_applied(std::shared_ptr<Connection> connection);
  void poll_applied();
  void end(Connection& connection);
  void watch_faults();

  const ModbusServerOptions options_;
  api::CommandSink& sink_;
  const api::SnapshotSource& source_;
  Counters counters_;

  // The following belongs to the listener's thread while it runs.
  protocols::LimitedLog log_;
  protocols::TcpService<Connection> service_;
  boost::asio::steady_timer apply_timer_{service_.io()}, fault_timer_{service_.io()};
  bool closed_ = false;  // the port, by an injected fault
  std::unique_ptr<RegisterBank> bank_;
  std::unique_ptr<ReplyBuilder> replies_;
  std::unique_ptr<ListenerContext> context_;
  std::vector<std::shared_ptr<Connection>> waiting_;
};

Result<std::uint16_t> ModbusServer::Impl::start() {
  if (context_) return fail(ErrorCode::kFailedPrecondition, "modbus", "already started");
  if (const auto problem = modbus::check(options_.scaling)) {
    return fail(ErrorCode::kInvalidArgument, "modbus.full_scale_m_s", *problem);
  }
  auto replies = ReplyBuilder::create();
  if (!replies) return tl::unexpected(replies.error());
  const auto port = service_.listen();
  if (!port) return port;
  replies_ = std::make_unique<ReplyBuilder>(std::move(*replies));
  bank_ = make_bank();
  context_ = std::make_unique<ListenerContext>(ListenerContext{
      service_.io(), options_, *bank_, *replies_, log_, counters_,
      modbus::RequestRules{options_.read_only, options_.unit_ids, bank_->addresses()}, source_,
      [this](std::shared_ptr<Connection> c) { await_applied(std::move(c)); },
      [this](Connection& c) { end(c); }});
  watch_faults();
  service_.start();
  return *port;
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

ModbusServerStats ModbusServer::Impl::stats() const {
  ModbusServerStats stats;
  const protocols::TcpListener& listener = service_.listener();
  stats.accepted = listener.accepted();
  stats.refused = listener.refused();
  stats.dropped = counters_.dropped;
  stats.open = listener.open();
  stats.requests = counters_.requests;
  stats.exceptions = counters_.exceptions;
  stats.answer_times = counters_.answer_times.counts();
  return stats;
}

ModbusServer::ModbusServer(ModbusServerOptions options, api::CommandSink& sink,
                           const api::SnapshotSource& source)
    : impl_(std::make_unique<Impl>(std::move(options), sink, source)) {}
ModbusServer::~ModbusServer() = default;
Result<std::uint16_t> ModbusServer::start() { return impl_->start(); }
void ModbusServer::stop() { impl_->stop(); }
ModbusServerStats ModbusServer::stats() const { return impl_->stats(); }

}  // namespace aprsim::modbus_server
