#include "protocols/crcl/crcl_server.hpp"

#include <utility>

#include <spdlog/spdlog.h>

#include "crcl/xml_tree.hpp"
#include "protocols/crcl/command_lifecycle.hpp"
#include "protocols/crcl/crcl_connection.hpp"
#include "protocols/tcp_service.hpp"

namespace aprsim::protocols {

namespace {

constexpr auto kProgramPeriod = std::chrono::milliseconds(1);

CommandLifecycleOptions link_options(const CrclServerOptions& options) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  CommandLifecycleOptions link;
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
        service_({link_.name(), options_.bind_address, options_.port, options_.max_connections},
                 options_.drain_deadline,
                 [this](TcpListener::Socket socket, std::string peer) {
                   return std::make_shared<CrclConnection>(
                       std::move(socket), std::move(peer), options_, link_, counters_,
                       [this](const CrclConnection& ended) { service_.ended(ended); });
                 }),
        program_timer_(service_.io()) {
    crcl::initialize_xml();
    link_.on_program([this] { follow_program(); });
  }

  ~Impl() { stop(); }

  Result<std::uint16_t> start() {
    const Result<std::uint16_t> port = service_.listen();
    if (!port) return port;
    spdlog::info("{}: listening on {} port {}", link_.name(), options_.bind_address, *port);
    service_.start();
    return port;
  }

  void stop() {
    service_.stop([this] { program_timer_.cancel(); });
  }

  [[nodiscard]] CrclServerStats stats() const {
    const TcpListener& listener = service_.listener();
    return {listener.accepted(), listener.refused(), counters_.dropped,
            listener.open(),     counters_.commands, counters_.statuses};
  }

 private:
  // A program goes on though no client asks for anything.
  void follow_program() {
    program_timer_.expires_after(kProgramPeriod);
    program_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (cancelled || service_.draining()) return;
      link_.advance();
      if (link_.runs_program()) follow_program();
    });
  }

  CrclServerOptions options_;
  CommandLifecycle link_;
  CrclCounters counters_;
  TcpService<CrclConnection> service_;
  boost::asio::steady_timer program_timer_;
};

CrclServer::CrclServer(CrclServerOptions options, api::CommandSink& sink,
                       const api::SnapshotSource& source)
    : impl_(std::make_unique<Impl>(std::move(options), sink, source)) {}

CrclServer::~CrclServer() = default;

Result<std::uint16_t> CrclServer::start() { return impl_->start(); }

void CrclServer::stop() { impl_->stop(); }

CrclServerStats CrclServer::stats() const { return impl_->stats(); }

}  // namespace aprsim::protocols
