#include "protocols/messages/snapshot_mask.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

namespace aprsim::protocols {
namespace {

constexpr std::size_t kMostShown = 128;  // of a path, in an error

}  // namespace

Result<SnapshotMask> SnapshotMask::parse(const google::protobuf::FieldMask& mask) {
  SnapshotMask out;
  for (const std::string& path : mask.paths()) {
    const google::protobuf::Descriptor* type = v1::Snapshot::descriptor();
    std::vector<Node>* nodes = &out.wanted_;
    Node* node = nullptr;
    for (std::string_view rest = path;;) {
      const std::string name(rest.substr(0, rest.find('.')));
      const Field* field = type != nullptr ? type->FindFieldByName(name) : nullptr;
      if (field == nullptr) {
        const std::string where = node != nullptr ? node->field->full_name() : "aprsim.v1.Snapshot";
        return fail(ErrorCode::kInvalidArgument, "read_mask",
                    "'" + path.substr(0, kMostShown) + "' leads nowhere: " + where +
                        " has no field '" + name.substr(0, kMostShown) + "'");
      }
      const auto found = std::ranges::find(*nodes, field, &Node::field);
      node = found != nodes->end() ? &*found : &nodes->emplace_back(Node{field, false, {}});
      nodes = &node->below;
      type = field->is_map() ? nullptr : field->message_type();
      if (rest.size() == name.size()) break;
      rest.remove_prefix(name.size() + 1);
    }
    node->whole = true;
  }
  return out;
}

bool SnapshotMask::wants(int field) const {
  return wanted_.empty() || std::ranges::any_of(wanted_, [field](const Node& node) {
           return node.field->number() == field;
         });
}

void SnapshotMask::trim(v1::Snapshot& message) const {
  if (!wanted_.empty()) trim(wanted_, message);
}

void SnapshotMask::trim(const std::vector<Node>& wanted, google::protobuf::Message& message) {
  const auto& reflection = *message.GetReflection();
  std::vector<const Field*> present;
  reflection.ListFields(message, &present);
  for (const Field* field : present) {
    const auto node = std::ranges::find(wanted, field, &Node::field);
    if (node == wanted.end()) {
      reflection.ClearField(&message, field);
    } else if (!node->whole && field->is_repeated()) {
      for (int i = 0; i < reflection.FieldSize(message, field); ++i) {
        trim(node->below, *reflection.MutableRepeatedMessage(&message, field, i));
      }
    } else if (!node->whole) {
      trim(node->below, *reflection.MutableMessage(&message, field));
    }
  }
}

std::string SnapshotMask::key() const {
  std::string out;
  write_key(wanted_, out);
  return out;
}

void SnapshotMask::write_key(const std::vector<Node>& wanted, std::string& out) {
  std::vector<const Node*> sorted;
  for (const Node& node : wanted) sorted.push_back(&node);
  std::ranges::sort(sorted, {}, [](const Node* node) { return node->field->number(); });
  for (const Node* node : sorted) {
    out += std::to_string(node->field->number());
    if (!node->whole) {
      out += '(';
      write_key(node->below, out);
      out += ')';
    }
    out += ' ';
  }
}

}  // namespace aprsim::protocols
