#pragma once

#include <vector>

#include <google/protobuf/field_mask.pb.h>

#include "aprsim/v1/snapshot.pb.h"
#include "world/api/error.hpp"

namespace aprsim::telemetry {

/// The part of a Snapshot message that a client asked for: a set of its top-level fields.
class SnapshotMask {
 public:
  /// All fields for an empty mask. A path that is not a top-level field of Snapshot is
  /// kInvalidArgument.
  [[nodiscard]] static Result<SnapshotMask> parse(const google::protobuf::FieldMask& mask);
  /// Clears every field that is not wanted.
  void trim(v1::Snapshot& message) const;

 private:
  std::vector<const google::protobuf::FieldDescriptor*> unwanted_;
};

}  // namespace aprsim::telemetry
