#include "protocols/web/http/request_text.hpp"

#include <google/protobuf/util/json_util.h>

namespace aprsim::web {
namespace {

/// Name of the set field of the message's only oneof; empty where none is set.
std::string choice_of(const google::protobuf::Message& message) {
  const auto* field = message.GetReflection()->GetOneofFieldDescriptor(
      message, message.GetDescriptor()->oneof_decl(0));
  return field == nullptr ? std::string() : field->name();
}

std::string robot_of(std::uint32_t index, const api::CellDescription& cell) {
  return index < cell.robots.size() ? cell.robots[index].name + " " : "";
}

}  // namespace

std::string title_of(const v1::ViewerRequest& request, const api::CellDescription& cell) {
  if (request.has_robot()) {
    return robot_of(request.robot().robot(), cell) + choice_of(request.robot());
  }
  if (request.has_jog()) {
    const std::string direction = choice_of(request.jog());
    return robot_of(request.jog().robot(), cell) + "jog " + (direction.empty() ? "end" : direction);
  }
  return choice_of(request);
}

std::string json_of(const v1::ViewerRequest& request) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  std::string text;
  // Cannot fail for these messages; a partial text would do for the record.
  (void)google::protobuf::util::MessageToJsonString(request, &text, options);
  return text;
}

}  // namespace aprsim::web
