#include "protocols/messages/snapshot_view.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::protocols {
namespace {

template <typename Things>
std::vector<bool> chosen(const Things& things, const std::set<std::string, std::less<>>& names) {
  std::vector<bool> out;
  out.reserve(things.size());
  for (const auto& thing : things) out.push_back(names.contains(thing.name));
  return out;
}

}  // namespace

Result<SnapshotView> SnapshotView::parse(const google::protobuf::FieldMask& mask,
                                         const Names& entities, const api::CellDescription& cell) {
  auto parsed = SnapshotMask::parse(mask);
  if (!parsed) return tl::unexpected(parsed.error());
  SnapshotView view;
  view.mask_ = *std::move(parsed);
  for (std::size_t field = 0; field < view.without_.size(); ++field) {
    view.without_[field] = !view.mask_.wants(static_cast<int>(field));
  }
  for (const std::string& name : entities) {
    const auto called = [&](const auto& thing) { return thing.name == name; };
    if (std::ranges::none_of(cell.robots, called) && std::ranges::none_of(cell.bodies, called) &&
        std::ranges::none_of(cell.tools, called)) {
      return fail(ErrorCode::kNotFound, "entities",
                  "no robot, body or tool is called '" + name.substr(0, 64) + "'");
    }
    view.names_.insert(name);
  }
  return view;
}

void SnapshotView::write(const api::Snapshot& snapshot, const std::string& instance_id,
                         v1::Snapshot& message) const {
  SnapshotParts parts{.without = without_};
  SnapshotParts::Entities entities;
  if (!names_.empty()) {
    const api::CellDescription& cell = *snapshot.cell;
    entities = {chosen(cell.robots, names_), chosen(cell.bodies, names_),
                chosen(cell.tools, names_)};
    parts.entities = &entities;
  }
  write_message(snapshot, instance_id, message, parts);
  mask_.trim(message);
}

std::string SnapshotView::key() const {
  std::string key = mask_.key();
  for (const std::string& name : names_) key += '\n' + name;
  return key;
}

}  // namespace aprsim::protocols
