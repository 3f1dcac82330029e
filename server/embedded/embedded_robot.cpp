#include "server/embedded/embedded_robot.hpp"

#include <chrono>
#include <optional>
#include <utility>

#include "protocols/crcl/crcl_server.hpp"
#include "server/listeners/endpoints.hpp"

namespace aprsim::embedded {
namespace {

/// Longest wait for a status that an injected fault delays.
constexpr std::chrono::seconds kLongestDelay{60};

crcl_server::CrclServerOptions options_of(int robot) {
  crcl_server::CrclServerOptions options;
  options.robot = robot;
  options.listener.endpoint = server::kFirstCrclEndpoint + static_cast<api::EndpointId>(robot);
  // As of a daemon without configuration.
  options.units.length = crcl::LengthUnit::kMillimeter;
  options.units.angle = crcl::AngleUnit::kDegree;
  return options;
}

}  // namespace

/// Frames the client's bytes and carries the documents of its session.
class EmbeddedRobot::Wire final : public crcl_server::SessionWire,
                                  public std::enable_shared_from_this<Wire> {
 public:
  Wire(const crcl_server::CrclServerOptions& options, crcl_server::CommandExecutor& executor,
       crcl_server::CrclCounters& counters, const boost::asio::any_io_executor& io)
      : framer_(crcl::Framer::for_commands(options.max_message_bytes, options.max_program_bytes)),
        session_(
            options, executor, counters, io, "this process", nullptr, [] {}, *this) {}

  void receive(std::string_view bytes) {
    framer_.append(bytes);
    process();
  }
  void close() {
    ended_ = true;
    session_.close();
  }
  [[nodiscard]] std::string take_output() { return std::exchange(output_, {}); }
  [[nodiscard]] bool is_waiting() const {
    return output_.empty() && !ended_ && (session_.busy() || !session_.all_sent());
  }
  [[nodiscard]] const std::string& reason() const { return reason_; }

  // The wire, as the session sees it.
  [[nodiscard]] std::shared_ptr<SessionWire> hold() override { return shared_from_this(); }
  [[nodiscard]] bool carries_documents() const override { return true; }
  [[nodiscard]] bool closed() const override { return ended_; }
  [[nodiscard]] bool ended() const override { return ended_; }
  [[nodiscard]] bool admits_command() override { return !ended_; }
  void send(crcl_server::Answer answer) override { output_ += answer.document; }
  void send_half(crcl_server::Answer answer) override {
    output_ += answer.document.substr(0, answer.document.size() / 2);
    drop("an injected fault");
  }
  void on_room() override {}
  void on_taken() override { process(); }
  void watch_end() override {}
  void refuse(const std::string& reason) override { drop(reason); }
  void drop(const std::string& reason) override {
    reason_ = reason;
    ended_ = true;
  }

 private:
  void process() {
    while (!ended_ && !session_.busy()) {
      crcl::Result<std::optional<std::string>> document = framer_.next();
      if (!document) return session_.fail(document.error());
      if (!*document) return;
      const auto now = std::chrono::steady_clock::now();
      if (framer_.last_root() == 0) {
        session_.take(crcl_server::CommandDocument{*std::move(*document)}, now);
      } else {
        session_.take(crcl_server::ProgramDocument{*std::move(*document)}, now);
      }
    }
  }

  crcl::Framer framer_;
  crcl_server::CrclSession session_;
  std::string output_;
  std::string reason_;  ///< of the end
  bool ended_ = false;
};

EmbeddedRobot::EmbeddedRobot(int robot, api::CommandSink& sink, const api::SnapshotSource& source)
    : options_(options_of(robot)),
      executor_(crcl_server::executor_options(options_), sink, source) {
  reconnect();
}

EmbeddedRobot::~EmbeddedRobot() { wire_->close(); }

void EmbeddedRobot::reconnect() {
  if (wire_) wire_->close();
  wire_ = std::make_shared<Wire>(options_, executor_, counters_, io_.get_executor());
}

Result<void> EmbeddedRobot::send(std::string_view bytes) {
  if (wire_->ended()) {
    return fail(ErrorCode::kUnavailable, executor_.robot(),
                "the robot has closed the connection: " + wire_->reason());
  }
  wire_->receive(bytes);
  return {};
}

std::string EmbeddedRobot::take_statuses() {
  io_.restart();
  io_.poll();
  const auto deadline = std::chrono::steady_clock::now() + kLongestDelay;
  while (wire_->is_waiting() && io_.run_one_until(deadline) > 0) {
  }
  return wire_->take_output();
}

}  // namespace aprsim::embedded
