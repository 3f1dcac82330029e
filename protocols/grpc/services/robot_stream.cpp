#include "protocols/grpc/services/robot_stream.hpp"

#include <utility>

#include "crcl/messages.hpp"
#include "protocols/grpc/calls/rpc_status.hpp"
#include "protocols/grpc/services/robot_service.hpp"

namespace aprsim::grpc_server {

RobotStream::RobotStream(const RobotService& service, grpc::CallbackServerContext& context,
                         std::optional<grpc::Status> refused)
    : service_(service), context_(context), refused_(std::move(refused)) {}

void RobotStream::begin(std::shared_ptr<RobotStream> self) {
  self_ = std::move(self);
  const std::lock_guard lock(mutex_);
  if (refused_) return end(*refused_);
  StartSendInitialMetadata();  // the client learns that it is let in
  StartRead(&request_);
}

void RobotStream::OnReadDone(bool ok) {
  if (ok) return take_request();
  const std::lock_guard lock(mutex_);
  client_done_ = true;
  end_if_over();
}

// One at a time: the next is read only when the robot has taken this one.
void RobotStream::take_request() {
  using Request = crcl::v1::ConnectRequest;
  const auto refuse = [this](const char* why) {
    const std::lock_guard lock(mutex_);
    end({grpc::StatusCode::INVALID_ARGUMENT, why});
  };
  const Request::ContentCase content = request_.content_case();
  if (!session_) {
    if (content != Request::kOptions) return refuse("options: come first, and name the robot");
    auto session = service_.open(request_.options(), nullptr, context_, self_);
    const std::lock_guard lock(mutex_);
    if (!session) return end(rpc_status(session.error()));
    session_ = *std::move(session);
    return read();
  }
  if (content == Request::kOptions) return refuse("options: come once");
  if (content == Request::CONTENT_NOT_SET) return refuse("content: neither command nor program");
  {
    const std::lock_guard lock(mutex_);
    taking_ = true;
    if (request_.command().command().has_get_status()) ++expected_;
  }
  if (content == Request::kProgram) {
    session_->send(crcl::from_message(request_.program()));
  } else {
    session_->send(crcl::from_message(request_.command()));
  }
}

void RobotStream::on_taken() {
  const std::lock_guard lock(mutex_);
  taking_ = false;
  held_ = pending_.size() >= kMaxPending;
  if (!held_) read();
}

void RobotStream::read() {
  if (!finished_ && !end_ && !client_done_) StartRead(&request_);
}

void RobotStream::on_status(const crcl::Status& status) {
  crcl::v1::ConnectResponse response;
  *response.mutable_status() = crcl::to_message(status);
  const std::lock_guard lock(mutex_);
  if (expected_ > 0) --expected_;
  if (finished_ || end_) return;
  pending_.push_back(std::move(response));
  if (!writing_) write();
}

void RobotStream::write() {
  writing_ = true;
  StartWrite(&pending_.front());
}

void RobotStream::OnWriteDone(bool ok) {
  const std::lock_guard lock(mutex_);
  writing_ = false;
  pending_.pop_front();
  if (!ok && !end_) end_ = grpc::Status::CANCELLED;
  if (!pending_.empty() && ok) {
    write();
  } else if (end_) {
    return end(*end_);
  }
  if (held_ && pending_.size() < kMaxPending) {
    held_ = false;
    read();
  }
  end_if_over();
}

// Messages on their way go out first.
void RobotStream::end(const grpc::Status& status) {
  if (finished_) return;
  if (!end_) end_ = status;
  if (writing_) return;
  finished_ = true;
  Finish(*end_);
}

// As the port does for a client that has only finished sending.
void RobotStream::end_if_over() {
  if (client_done_ && !taking_ && expected_ == 0 && pending_.empty()) end(grpc::Status::OK);
}

void RobotStream::on_end(const Error& reason) {
  const std::lock_guard lock(mutex_);
  end(rpc_status(reason));
}

void RobotStream::OnCancel() {
  const std::lock_guard lock(mutex_);
  end(grpc::Status::CANCELLED);
}

void RobotStream::OnDone() {
  // The session knows its client: neither may keep the other.
  if (const auto session = std::exchange(session_, nullptr)) session->close();
  self_.reset();
}

void StatusStream::begin(std::shared_ptr<StatusStream> self,
                         Result<std::shared_ptr<protocols::RobotSession>> session,
                         std::chrono::nanoseconds period) {
  self_ = std::move(self);
  if (!session) {
    const std::lock_guard lock(mutex_);
    return end(rpc_status(session.error()));
  }
  session_ = *std::move(session);
  session_->report_every(period);
}

void StatusStream::on_status(const crcl::Status& status) {
  const std::lock_guard lock(mutex_);
  if (finished_ || end_) return;
  if (waiting_) ++dropped_;
  waiting_ = status;
  if (!writing_) write();
}

void StatusStream::write() {
  response_.Clear();
  *response_.mutable_status() = crcl::to_message(*std::exchange(waiting_, std::nullopt));
  response_.set_dropped_count(dropped_);
  writing_ = true;
  StartWrite(&response_);
}

void StatusStream::OnWriteDone(bool ok) {
  const std::lock_guard lock(mutex_);
  writing_ = false;
  if (!ok && !end_) end_ = grpc::Status::CANCELLED;
  if (end_) return end(*end_);
  if (waiting_) write();
}

void StatusStream::end(const grpc::Status& status) {
  if (finished_) return;
  if (!end_) end_ = status;
  if (writing_) return;
  finished_ = true;
  Finish(*end_);
}

void StatusStream::on_end(const Error& reason) {
  const std::lock_guard lock(mutex_);
  end(rpc_status(reason));
}

void StatusStream::OnCancel() {
  const std::lock_guard lock(mutex_);
  end(grpc::Status::CANCELLED);
}

void StatusStream::OnDone() {
  // The session knows its client: neither may keep the other.
  if (const auto session = std::exchange(session_, nullptr)) session->close();
  self_.reset();
}

}  // namespace aprsim::grpc_server
