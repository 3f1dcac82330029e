#include "protocols/crcl/port_session.hpp"

#include <utility>

#include <boost/asio/post.hpp>

namespace aprsim::crcl_server {
namespace {

using boost::system::error_code;

/// Period of checking whether a command is over.
constexpr auto kOverPeriod = std::chrono::milliseconds(1);

}  // namespace

PortSession::PortSession(const protocols::RobotSessionOptions& asked,
                         std::shared_ptr<protocols::RobotClient> client,
                         const CrclServerOptions& options, CommandExecutor& executor,
                         CrclCounters& counters, boost::asio::any_io_executor io, OnEnd on_end)
    : client_(std::move(client)),
      executor_(executor),
      io_(io),
      on_end_(std::move(on_end)),
      session_(
          options, executor, counters, io, asked.peer, nullptr, [] {}, *this),
      report_timer_(io),
      over_timer_(io) {
  ConnectionSettings& settings = *session_.caller().settings;
  settings.wait_for_end_effector();
  settings.report_everything();
  if (asked.length) settings.apply(crcl::SetUnits{*asked.length});
  if (asked.angle) settings.apply(crcl::SetUnits{*asked.angle});
  if (asked.force) settings.apply(crcl::SetUnits{*asked.force});
  if (asked.torque) settings.apply(crcl::SetUnits{*asked.torque});
  if (asked.report) settings.apply(*asked.report);
}

void PortSession::post(std::function<void()> work) {
  boost::asio::post(io_, [self = shared_from_this(), work = std::move(work)] {
    if (!self->closed_) work();
  });
}

void PortSession::send(crcl::Result<crcl::CommandInstance> command) {
  post([this, command = std::move(command)] { take(command); });
}

void PortSession::send(crcl::Result<crcl::Program> program) {
  post([this, program = std::move(program)] { take(program); });
}

void PortSession::execute(crcl::Result<crcl::CommandInstance> command) {
  post([this, command = std::move(command)] {
    executes_ = true;
    take(command);
  });
}

void PortSession::report_every(std::chrono::nanoseconds period) {
  post([this, period] {
    period_ = period;
    report();
  });
}

void PortSession::close() {
  post([this] { close_now(); });
}

void PortSession::take(Received received) {
  taking_ = true;
  session_.take(std::move(received), std::chrono::steady_clock::now());
  if (!closed_ && !session_.busy()) on_taken();
}

void PortSession::on_taken() {
  if (closed_ || !std::exchange(taking_, false)) return;
  if (executes_) {
    command_ = executor_.commands();
    watch_over();
  }
  client_->on_taken();
}

void PortSession::watch_over() {
  const bool replaced = executor_.commands() != command_;
  if (replaced || executor_.over()) {
    return client_->on_over(executor_.status(*session_.caller().settings), replaced);
  }
  over_timer_.expires_after(kOverPeriod);
  over_timer_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (!cancelled && !self->closed_) self->watch_over();
  });
}

// As if the client polled.
void PortSession::report() {
  if (!session_.busy()) {
    crcl::Result<crcl::CommandInstance> poll;
    poll->command.body = crcl::GetStatus{};
    session_.take(std::move(poll), std::chrono::steady_clock::now());
  }
  if (closed_) return;
  report_timer_.expires_after(period_);
  report_timer_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (!cancelled && !self->closed_) self->report();
  });
}

void PortSession::send(Answer answer) { client_->on_status(answer.status); }

// The session has already logged and counted the fault.
void PortSession::refuse(const std::string& reason) { end(ErrorCode::kInvalidArgument, reason); }

void PortSession::drop(const std::string& reason) {
  executor_.log().warn("closing " + session_.caller().peer + ": " + reason);
  end(ErrorCode::kUnavailable, reason);
}

void PortSession::end(ErrorCode code, const std::string& reason) {
  if (closed_) return;
  const std::shared_ptr<PortSession> self = shared_from_this();
  close_now();
  client_->on_end({code, executor_.name(), reason});
}

void PortSession::close_now() {
  if (std::exchange(closed_, true)) return;
  session_.close();
  error_code ignored;
  report_timer_.cancel(ignored);
  over_timer_.cancel(ignored);
  executor_.client_gone(session_.caller());
  on_end_(*this);
}

}  // namespace aprsim::crcl_server
