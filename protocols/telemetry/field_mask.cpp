#include "protocols/telemetry/field_mask.hpp"

#include <algorithm>

namespace aprsim::telemetry {

Result<SnapshotMask> SnapshotMask::parse(const google::protobuf::FieldMask& mask) {
  const google::protobuf::Descriptor& type = *v1::Snapshot::descriptor();
  for (const std::string& path : mask.paths()) {
    if (type.FindFieldByName(path) == nullptr) {
      return fail(ErrorCode::kInvalidArgument, "read_mask",
                  "'" + path.substr(0, 64) + "' is not a top-level field of aprsim.v1.Snapshot");
    }
  }
  SnapshotMask out;
  if (mask.paths().empty()) return out;
  for (int i = 0; i < type.field_count(); ++i) {
    const auto* field = type.field(i);
    if (std::ranges::find(mask.paths(), field->name()) == mask.paths().end()) {
      out.unwanted_.push_back(field);
    }
  }
  return out;
}

void SnapshotMask::trim(v1::Snapshot& message) const {
  for (const auto* field : unwanted_) message.GetReflection()->ClearField(&message, field);
}

}  // namespace aprsim::telemetry
