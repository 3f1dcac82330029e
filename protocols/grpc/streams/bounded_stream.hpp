#pragma once

#include <chrono>
#include <mutex>
#include <utility>

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

namespace aprsim::grpc_server {

/// A stream to one client with at most one write in flight, which ends the call when a write gets
/// stuck. Derived streams say what comes next. Thread: any, unless stated.
template <typename Response>
class BoundedStream : public grpc::ServerWriteReactor<Response> {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit BoundedStream(grpc::CallbackServerContext& context) : context_(context) {}

  /// Sends the initial metadata. Call it first.
  void begin() { this->StartSendInitialMetadata(); }
  /// Cancels the call if one write has been in flight for longer than that. Thread: the hub's.
  void cancel_if_stuck(Time now, std::chrono::milliseconds write_timeout) {
    const std::lock_guard lock(mutex_);
    if (finished_ || !writing_ || !has_begun() || now - write_started_ < write_timeout) return;
    context_.TryCancel();
  }
  /// Ends the call with the status, at once if no write is in flight, else by cancelling it.
  void end(const grpc::Status& status) {
    const std::lock_guard lock(mutex_);
    if (finished_ || ending_) return;
    ending_ = true;
    end_status_ = status;
    if (!writing_) return finish(end_status_);
    stop();
    // A message may be stuck; the beginning of the call is through in a moment.
    if (has_begun()) context_.TryCancel();
  }

  void OnSendInitialMetadataDone(bool ok) override { OnWriteDone(ok); }
  void OnWriteDone(bool ok) override {
    Lock lock(mutex_);
    writing_ = false;
    if (!ok || ending_) return finish(ending_ ? end_status_ : grpc::Status::CANCELLED);
    next(std::move(lock));
  }
  void OnCancel() override { end(grpc::Status::CANCELLED); }

 protected:
  using Lock = std::unique_lock<std::mutex>;

  /// Sends what is due, if anything; called when nothing is in flight.
  virtual void next(Lock lock) = 0;
  /// The call ends, with the stream locked; more than once.
  virtual void stop() {}

  [[nodiscard]] Lock lock() { return Lock(mutex_); }
  /// The rest only with the stream locked.
  [[nodiscard]] bool is_writing() const { return writing_; }
  [[nodiscard]] bool is_over() const { return finished_ || ending_; }
  /// False until the initial metadata is through.
  [[nodiscard]] bool has_begun() const { return write_started_ != Time{} || !writing_; }
  /// Reserves the write: the message is then the caller's alone, until StartWrite() is done.
  void begin_write() {
    writing_ = true;
    write_started_ = std::chrono::steady_clock::now();
  }
  void finish(const grpc::Status& status) {
    finished_ = true;
    stop();
    this->Finish(status);
  }

 private:
  grpc::CallbackServerContext& context_;
  std::mutex mutex_;
  bool writing_ = true;  // until the call has begun
  bool finished_ = false, ending_ = false;
  grpc::Status end_status_;
  Time write_started_;
};

}  // namespace aprsim::grpc_server
