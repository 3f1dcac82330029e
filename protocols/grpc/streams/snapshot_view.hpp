#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include <google/protobuf/repeated_field.h>
#include <grpcpp/support/slice.h>

#include "protocols/grpc/calls/field_mask.hpp"
#include "protocols/messages/write_message.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::grpc_server {

/// The part of snapshots that a client requests: fields, and things by their names.
class SnapshotView {
 public:
  using Names = google::protobuf::RepeatedPtrField<std::string>;
  /// Errors: kInvalidArgument for a path that leads nowhere, kNotFound for a name that nothing in
  /// the cell has.
  [[nodiscard]] static Result<SnapshotView> parse(const google::protobuf::FieldMask& mask,
                                                  const Names& entities,
                                                  const api::CellDescription& cell);

  /// The message must be empty.
  void write(const api::Snapshot& snapshot, const std::string& instance_id,
             v1::Snapshot& message) const;
  /// Equal for equal views.
  [[nodiscard]] std::string key() const;

 private:
  SnapshotMask mask_;
  std::bitset<128> without_;
  std::set<std::string, std::less<>> names_;  // empty = all
};

/// A view that several streams share: each snapshot is encoded once. Thread: any.
class SharedView {
 public:
  SharedView(SnapshotView view, std::string instance_id)
      : view_(std::move(view)), instance_id_(std::move(instance_id)) {}

  /// The serialized message; the latest one is kept for the others.
  [[nodiscard]] grpc::Slice encode(const api::SnapshotPtr& snapshot);

 private:
  const SnapshotView view_;
  const std::string instance_id_;
  std::mutex mutex_;
  api::SnapshotPtr latest_;
  grpc::Slice encoded_;
};

/// The views that are in use. Thread: any.
class SharedViews {
 public:
  explicit SharedViews(std::string instance_id) : instance_id_(std::move(instance_id)) {}
  [[nodiscard]] std::shared_ptr<SharedView> share(SnapshotView view);

 private:
  const std::string instance_id_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<SharedView>> all_;  // by key
};

}  // namespace aprsim::grpc_server
