#include "protocols/simple_message/simple_message_server.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <boost/asio/post.hpp>
#include <spdlog/spdlog.h>

#include "protocols/net/tcp_service.hpp"
#include "protocols/net/time_pacer.hpp"
#include "protocols/ports/wire_faults.hpp"
#include "protocols/simple_message/fanuc_controller.hpp"
#include "protocols/simple_message/motoman_controller.hpp"
#include "protocols/simple_message/state_cadence.hpp"

namespace aprsim::simple_message {
namespace {

using boost::system::error_code;
using protocols::TcpListener;

/// Period of looking at the cell while a client waits for it.
constexpr std::chrono::milliseconds kCellPeriod{1};
/// Period of looking for injected faults, and for the end of peers that nothing is read from.
constexpr std::chrono::milliseconds kFaultPeriod{10};
/// Clients of the Motoman's state port at once.
constexpr std::size_t kMotomanStates = 4;

constexpr std::array<const char*, 3> kRoleNames{"motion", "state", "gripper"};

std::string robot_name(const SimpleMessageOptions& options, const api::SnapshotSource& source) {
  return source.latest()->cell->robots.at(static_cast<std::size_t>(options.robot)).name;
}

}  // namespace

class SimpleMessageServer::Impl final : public ConnectionOwner {
 public:
  Impl(SimpleMessageOptions options, api::CommandSink& sink, const api::SnapshotSource& source)
      : options_(std::move(options)),
        robot_(robot_name(options_, source)),
        log_("simple_message." + robot_),
        source_(source),
        link_(options_, sink, source),
        service_(name_of(Role::kMotion), port_options(options_.motion_port), make(Role::kMotion)),
        state_listener_(service_.add(name_of(Role::kState), port_options(options_.state_port),
                                     make(Role::kState))),
        gripper_listener_(service_.add(name_of(Role::kGripper), port_options(options_.gripper_port),
                                       make(Role::kGripper))),
        context_{service_.io(), options_, source, log_, counters_, *this, ByteOrder::kBig},
        drops_(faults::Kind::kSimpleMessageDrop, options_.robot),
        cell_pacer_(options_.listener.virtual_time, service_.io().get_executor()),
        state_pacer_(options_.listener.virtual_time, service_.io().get_executor()),
        cell_timer_(service_.io()),
        state_timer_(service_.io()),
        fault_timer_(service_.io()) {
    if (options_.controller == ControllerKind::kFanucKarel) {
      controller_ = std::make_unique<FanucController>(context_, link_);
    } else {
      controller_ = std::make_unique<MotomanController>(context_, link_);
    }
  }
  ~Impl() override { stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<SimpleMessagePorts> start();
  void stop();
  void set_robot(int robot, std::function<void()> change);
  [[nodiscard]] SimpleMessageStats stats() const;

  [[nodiscard]] bool take(Connection& connection, std::span<const std::uint8_t> request,
                          bool known_length) override;
  [[nodiscard]] bool owes(const Connection& connection) const override {
    return controller_->owes(connection);
  }
  void ended(Connection& connection) override;
  void written(Connection& connection) override {
    if (connection.role() == Role::kState) ask_for_states();
  }
  void time_passed() override {
    follow_faults();
    controller_->advance();
  }

 private:
  /// Connections of one port in the order of their arrival.
  using Clients = std::vector<Connection*>;

  [[nodiscard]] std::string name_of(Role role) const {
    return std::string(kRoleNames[static_cast<std::size_t>(role)]) + "." + robot_;
  }
  [[nodiscard]] protocols::ListenerOptions port_options(std::uint16_t port) const {
    protocols::ListenerOptions options = options_.listener;
    options.port = port;
    return options;
  }
  [[nodiscard]] protocols::TcpService<Connection>::Make make(Role role);
  [[nodiscard]] Clients& clients(Role role) { return clients_[static_cast<std::size_t>(role)]; }
  [[nodiscard]] bool is_motoman() const {
    return options_.controller == ControllerKind::kMotomanFs100;
  }
  [[nodiscard]] std::string admit(Role role);
  [[nodiscard]] bool serves(const Connection& connection);
  void watch_cell();
  void follow_cell();
  void keep_sending_states(std::chrono::steady_clock::time_point due);
  void send_states();
  void join_time();
  void ask_for_states();
  void watch_faults();
  void follow_faults();

  SimpleMessageOptions options_;  // the robot's index changes on the listener's thread
  const std::string robot_;       // its name in the scene that the server began with
  protocols::LimitedLog log_;
  const api::SnapshotSource& source_;
  Counters counters_;
  RobotLink link_;

  // The following belongs to the listener's thread while it runs.
  protocols::TcpService<Connection> service_;
  TcpListener& state_listener_;
  TcpListener& gripper_listener_;
  ListenerContext context_;
  std::unique_ptr<Controller> controller_;
  std::array<Clients, kRoleNames.size()> clients_;
  protocols::MomentaryFaults drops_;
  // In virtual time: has joined while a client waits for the cell; while a state port has readers.
  protocols::TimePacer cell_pacer_, state_pacer_;
  boost::asio::steady_timer cell_timer_, state_timer_, fault_timer_;
  bool closed_ = false;   // the ports, by an injected fault
  bool watches_ = false;  // the cell timer runs
};

Result<SimpleMessagePorts> SimpleMessageServer::Impl::start() {
  SimpleMessagePorts ports;
  const auto listen = [&](Role role, auto& listener, std::uint16_t& port) -> Result<void> {
    const auto bound = listener.listen();
    if (!bound) {
      Error error = bound.error();
      error.field = kRoleNames[static_cast<std::size_t>(role)];
      return tl::unexpected(std::move(error));
    }
    port = *bound;
    spdlog::info("{}: listening on {} port {}", name_of(role), options_.listener.address, port);
    return {};
  };
  if (auto ok = listen(Role::kMotion, service_, ports.motion); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = listen(Role::kState, state_listener_, ports.state); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = listen(Role::kGripper, gripper_listener_, ports.gripper); !ok) {
    return tl::unexpected(ok.error());
  }
  keep_sending_states(std::chrono::steady_clock::now());
  watch_faults();
  service_.start();
  return ports;
}

void SimpleMessageServer::Impl::stop() {
  service_.stop([this] {
    cell_pacer_.leave();
    state_pacer_.leave();
    cell_timer_.cancel();
    state_timer_.cancel();
    fault_timer_.cancel();
  });
}

void SimpleMessageServer::Impl::set_robot(int robot, std::function<void()> change) {
  boost::asio::post(service_.io(), [this, robot, change = std::move(change)] {
    change();
    options_.robot = robot;
    drops_ = protocols::MomentaryFaults(faults::Kind::kSimpleMessageDrop, robot);
  });
}

SimpleMessageStats SimpleMessageServer::Impl::stats() const {
  SimpleMessageStats stats;
  for (const TcpListener* listener :
       {&service_.listener(), const_cast<const TcpListener*>(&state_listener_),
        const_cast<const TcpListener*>(&gripper_listener_)}) {
    stats.accepted += listener->accepted();
    stats.refused += listener->refused();
    stats.open += listener->open();
  }
  stats.dropped = counters_.dropped;
  stats.requests = counters_.requests;
  stats.rejected = counters_.rejected;
  stats.skipped = counters_.skipped;
  stats.answer_times = counters_.answer_times.counts();
  return stats;
}

// ---- connections

protocols::TcpService<Connection>::Make SimpleMessageServer::Impl::make(Role role) {
  return [this, role](TcpListener::Socket socket, std::string peer, TcpListener::Slot slot) {
    const std::string refusal = admit(role);
    auto connection = std::make_shared<Connection>(
        std::move(socket), name_of(role), std::move(peer), std::move(slot), role, context_);
    if (!refusal.empty()) {
      connection->start_with(refusal);
      return connection;
    }
    clients(role).push_back(connection.get());
    if (role == Role::kState) join_time();
    if (role == Role::kMotion && serves(*connection)) controller_->motion_connected(*connection);
    return connection;
  };
}

/// MotoROS closes its oldest client for a new one; Karel serves one after the other. The reason for
/// closing the new one; empty = it is taken.
std::string SimpleMessageServer::Impl::admit(Role role) {
  Clients& present = clients(role);
  if (!is_motoman()) return {};
  const std::size_t places = role == Role::kState ? kMotomanStates : 1;
  if (present.size() < places) return {};
  if (role == Role::kMotion && !controller_->yields_motion()) {
    return "another client moves the robot";
  }
  present.front()->close("a new client takes its place", false);
  return {};
}

bool SimpleMessageServer::Impl::serves(const Connection& connection) {
  return is_motoman() || clients(connection.role()).front() == &connection;
}

bool SimpleMessageServer::Impl::take(Connection& connection, std::span<const std::uint8_t> request,
                                     bool known_length) {
  if (service_.draining() || !serves(connection)) return false;
  const bool taken = connection.role() == Role::kMotion
                         ? controller_->take_motion(connection, request, known_length)
                         : controller_->take_gripper(connection, request, known_length);
  if (!taken || controller_->waits()) watch_cell();
  return taken;
}

void SimpleMessageServer::Impl::ended(Connection& connection) {
  Clients& present = clients(connection.role());
  const auto found = std::ranges::find(present, &connection);
  if (found != present.end()) {
    const bool served = serves(connection);
    present.erase(found);
    if (served && connection.role() == Role::kMotion) {
      controller_->motion_gone(connection);
      if (!present.empty()) controller_->motion_connected(*present.front());
    }
    // The next one may have sent requests already.
    if (served && !present.empty()) watch_cell();
  }
  if (connection.role() == Role::kState) {
    if (present.empty()) state_pacer_.leave();
    ask_for_states();
  }
  service_.ended(connection);
}

// ---- timers

void SimpleMessageServer::Impl::watch_cell() {
  if (std::exchange(watches_, true)) return;
  // In virtual time the cell is followed at its own instants.
  cell_pacer_.join({log_.name(), api::PacerKind::kProgram, options_.listener.endpoint});
  if (cell_pacer_.joined()) {
    return cell_pacer_.after(kCellPeriod, [this] {
      watches_ = false;
      if (!service_.draining()) follow_cell();
    });
  }
  cell_timer_.expires_after(kCellPeriod);
  cell_timer_.async_wait([this](const error_code& cancelled) {
    watches_ = false;
    if (!cancelled && !service_.draining()) follow_cell();
  });
}

void SimpleMessageServer::Impl::follow_cell() {
  controller_->advance();
  service_.for_each([](Connection& connection) {
    if (connection.has_bytes()) connection.process();
  });
  if (controller_->waits()) return watch_cell();
  if (!watches_) cell_pacer_.leave();
}

void SimpleMessageServer::Impl::keep_sending_states(std::chrono::steady_clock::time_point due) {
  const auto next = next_state(due, controller_->state_period(), std::chrono::steady_clock::now());
  state_timer_.expires_at(next);
  state_timer_.async_wait([this, next](const error_code& cancelled) {
    if (!cancelled && !service_.draining()) keep_sending_states(next);
  });
  if (!state_pacer_.joined()) send_states();
}

// In virtual time, as long as somebody reads, time waits for every state to be taken.
void SimpleMessageServer::Impl::join_time() {
  if (options_.listener.virtual_time == nullptr || state_pacer_.joined() || service_.draining()) {
    return;
  }
  state_pacer_.join({name_of(Role::kState), api::PacerKind::kFeed, options_.listener.endpoint});
  // The connection that is being made comes first.
  boost::asio::post(service_.io(), [this] { ask_for_states(); });
}

void SimpleMessageServer::Impl::ask_for_states() {
  if (!state_pacer_.joined() || state_pacer_.waiting()) return;
  const auto busy = [](const Connection* reader) { return reader->busy(); };
  if (std::ranges::any_of(clients(Role::kState), busy)) return;
  state_pacer_.after(controller_->state_period(), [this] {
    send_states();
    ask_for_states();
  });
}

void SimpleMessageServer::Impl::send_states() {
  Clients& readers = clients(Role::kState);
  if (readers.empty()) return;
  const std::vector<std::string> messages = controller_->states();
  const Clients now = readers;
  for (Connection* reader : now) {
    if (!serves(*reader)) continue;
    for (const std::string& message : messages) reader->send_state(message);
  }
}

// A restarting controller closes its ports; a dropped connection may return at once.
void SimpleMessageServer::Impl::watch_faults() {
  fault_timer_.expires_after(kFaultPeriod);
  fault_timer_.async_wait([this](const error_code& cancelled) {
    if (!cancelled && !service_.draining()) watch_faults();
  });
  service_.for_each([](Connection& connection) { connection.notice_end(); });
  controller_->report_ends();
  // A pacing client sees faults at its own instants only.
  bool paces = false;
  service_.for_each([&](const Connection& connection) { paces |= connection.paces(); });
  if (!paces) follow_faults();
}

void SimpleMessageServer::Impl::follow_faults() {
  const api::SnapshotPtr now = source_.latest();
  const bool drop = drops_.happened(*now);
  const bool closed = protocols::injected(*now, faults::Kind::kControllerReboot, options_.robot);
  if (closed != closed_) service_.refuse_connections(closed);
  if (drop || (closed && !closed_)) {
    service_.for_each([](Connection& connection) { connection.close("an injected fault", true); });
  }
  closed_ = closed;
}

SimpleMessageServer::SimpleMessageServer(SimpleMessageOptions options, api::CommandSink& sink,
                                         const api::SnapshotSource& source)
    : impl_(std::make_unique<Impl>(std::move(options), sink, source)) {}
SimpleMessageServer::~SimpleMessageServer() = default;
Result<SimpleMessagePorts> SimpleMessageServer::start() { return impl_->start(); }
void SimpleMessageServer::stop() { impl_->stop(); }
void SimpleMessageServer::set_robot(int robot, std::function<void()> change) {
  impl_->set_robot(robot, std::move(change));
}
SimpleMessageStats SimpleMessageServer::stats() const { return impl_->stats(); }

}  // namespace aprsim::simple_message
