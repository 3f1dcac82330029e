#include "protocols/grpc/streams/state_transfer.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::grpc_server {

FileSender::FileSender(std::string bytes) : bytes_(std::move(bytes)) { write_next(); }

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

FileReceiver::FileReceiver(Take take) : take_(std::move(take)) { StartRead(&request_); }

void FileReceiver::OnReadDone(bool ok) {
  if (!ok) return take_(*this, std::move(name_), std::move(bytes_));
  if (std::exchange(first_, false)) name_ = request_.name();
  if (bytes_.size() + request_.data().size() > kMaxTransfer) {
    return Finish({grpc::StatusCode::RESOURCE_EXHAUSTED,
                   "data: more than " + std::to_string(kMaxTransfer) + " bytes"});
  }
  bytes_ += request_.data();
  StartRead(&request_);
}

}  // namespace aprsim::grpc_server
