#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include <grpcpp/support/slice.h>

#include "protocols/messages/snapshot_view.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::grpc_server {

/// A view that several streams share: each snapshot is encoded once. Thread: any.
class SharedView {
 public:
  SharedView(protocols::SnapshotView view, std::string instance_id)
      : view_(std::move(view)), instance_id_(std::move(instance_id)) {}

  /// The serialized message; the latest one is kept for the others.
  [[nodiscard]] grpc::Slice encode(const api::SnapshotPtr& snapshot);

 private:
  const protocols::SnapshotView view_;
  const std::string instance_id_;
  std::mutex mutex_;
  api::SnapshotPtr latest_;
  grpc::Slice encoded_;
};

/// The views that are in use. Thread: any.
class SharedViews {
 public:
  explicit SharedViews(std::string instance_id) : instance_id_(std::move(instance_id)) {}
  [[nodiscard]] std::shared_ptr<SharedView> share(protocols::SnapshotView view);

 private:
  const std::string instance_id_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<SharedView>> all_;  // by key
};

}  // namespace aprsim::grpc_server
