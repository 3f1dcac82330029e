#pragma once

#include <bitset>
#include <set>
#include <string>

#include <google/protobuf/repeated_field.h>

#include "protocols/messages/snapshot_mask.hpp"
#include "protocols/messages/write_message.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::protocols {

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

}  // namespace aprsim::protocols
