#pragma once

#include <string>
#include <vector>

#include <google/protobuf/field_mask.pb.h>

#include "aprsim/v1/snapshot.pb.h"
#include "world/base/result.hpp"

namespace aprsim::protocols {

/// The part of a Snapshot message that a client asked for, as paths of fields: a path through a
/// repeated field holds for all of its messages, as "robots.joints.position_rad".
class SnapshotMask {
 public:
  /// All fields for an empty mask. A path that leads nowhere is kInvalidArgument.
  [[nodiscard]] static Result<SnapshotMask> parse(const google::protobuf::FieldMask& mask);
  /// Clears every field outside the mask.
  void trim(v1::Snapshot& message) const;
  /// Whether the mask has something of a top-level field, by its number.
  [[nodiscard]] bool wants(int field) const;
  /// Equal for equal masks.
  [[nodiscard]] std::string key() const;

 private:
  using Field = google::protobuf::FieldDescriptor;
  struct Node {
    const Field* field = nullptr;
    bool whole = false;
    std::vector<Node> below;
  };
  static void trim(const std::vector<Node>& wanted, google::protobuf::Message& message);
  static void write_key(const std::vector<Node>& wanted, std::string& out);

  std::vector<Node> wanted_;  // empty = all
};

}  // namespace aprsim::protocols
