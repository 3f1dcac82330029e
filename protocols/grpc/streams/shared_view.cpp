#include "protocols/grpc/streams/shared_view.hpp"

#include <utility>

#include <google/protobuf/arena.h>

namespace aprsim::grpc_server {

grpc::Slice SharedView::encode(const api::SnapshotPtr& snapshot) {
  const std::lock_guard lock(mutex_);
  if (snapshot == latest_) return encoded_;
  google::protobuf::Arena arena;
  auto& message = *google::protobuf::Arena::CreateMessage<v1::Snapshot>(&arena);
  view_.write(*snapshot, instance_id_, message);
  encoded_ = grpc::Slice(message.SerializeAsString());
  latest_ = snapshot;
  return encoded_;
}

std::shared_ptr<SharedView> SharedViews::share(protocols::SnapshotView view) {
  std::string key = view.key();
  const std::lock_guard lock(mutex_);
  std::erase_if(all_, [](const auto& entry) { return entry.second.expired(); });
  auto& kept = all_[std::move(key)];
  auto shared = kept.lock();
  if (!shared) {
    shared = std::make_shared<SharedView>(std::move(view), instance_id_);
    kept = shared;
  }
  return shared;
}

}  // namespace aprsim::grpc_server
