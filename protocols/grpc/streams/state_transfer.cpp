#include "protocols/grpc/streams/state_transfer.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace aprsim::grpc_server {

namespace {

grpc::Status no_room(const TransferBudget& budget) {
  return {grpc::StatusCode::RESOURCE_EXHAUSTED,
          "data: all files on their way together have more than " +
              std::to_string(budget.max_bytes()) + " bytes; try again"};
}

}  // namespace

FileSender::FileSender(std::string bytes, TransferBudget& budget) {
  if (!budget.take(bytes.size())) {
    Finish(no_room(budget));
    return;
  }
  bytes_ = std::move(bytes);
  budget_ = &budget;
  taken_bytes_ = bytes_.size();
  write_next();
}

FileSender::~FileSender() {
  if (budget_ != nullptr) budget_->give_back(taken_bytes_);
}

void FileSender::write_next() {
  const std::size_t count = std::min(kTransferChunk, bytes_.size() - sent_);
  response_.set_data(bytes_.substr(sent_, count));
  sent_ += count;
  StartWrite(&response_);
}

void FileSender::OnWriteDone(bool ok) {
  if (!ok) return Finish(grpc::Status::CANCELLED);
  if (sent_ == bytes_.size()) return Finish(grpc::Status::OK);
  write_next();
}

FileReceiver::FileReceiver(const TransferLimits& limits, TransferBudget& budget, Take take)
    : limits_(limits), budget_(&budget), take_(std::move(take)) {
  set_alarm();
  StartRead(&request_);
}

FileReceiver::~FileReceiver() {
  if (budget_ != nullptr) budget_->give_back(taken_bytes_);
  if (!alarm_) return;
  {
    const std::lock_guard lock(alarm_->mutex);
    alarm_->receiver = nullptr;
  }
  alarm_->alarm.Cancel();
}

void FileReceiver::set_alarm() {
  alarm_ = std::make_shared<Alarm>();
  alarm_->receiver = this;
  alarm_->alarm.Set(std::chrono::system_clock::now() + limits_.time, [alarm = alarm_](bool due) {
    const std::lock_guard lock(alarm->mutex);
    if (!due || alarm->receiver == nullptr) return;
    alarm->receiver->end({grpc::StatusCode::DEADLINE_EXCEEDED,
                          "data: not complete within " +
                              std::to_string(alarm->receiver->limits_.time.count()) + " ms"});
  });
}

void FileReceiver::end(const grpc::Status& status) {
  if (!ended_.exchange(true)) Finish(status);
}

void FileReceiver::OnReadDone(bool ok) {
  if (ended_) return;
  if (!ok) {
    alarm_->alarm.Cancel();
    return take_(*this, std::move(name_), std::move(bytes_));
  }
  if (append_message()) StartRead(&request_);
}

/// False: the upload has been refused.
bool FileReceiver::append_message() {
  if (std::exchange(first_, false)) name_ = request_.name();
  const std::size_t size = request_.data().size();
  if (bytes_.size() + size > limits_.file_bytes) {
    end({grpc::StatusCode::RESOURCE_EXHAUSTED,
         "data: more than " + std::to_string(limits_.file_bytes) + " bytes"});
    return false;
  }
  if (!budget_->take(size)) {
    end(no_room(*budget_));
    return false;
  }
  taken_bytes_ += size;
  bytes_ += request_.data();
  return true;
}

}  // namespace aprsim::grpc_server
