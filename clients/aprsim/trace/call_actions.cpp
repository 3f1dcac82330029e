#include <memory>
#include <zlib.h>

#include <fmt/format.h>
#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>

#include "aprsim/v1/control_service.pb.h"
#include "aprsim/v1/web.pb.h"
#include "clients/aprsim/trace/action.hpp"

namespace aprsim::trace {
namespace {

namespace pb = google::protobuf;

void add_fields(const std::string& prefix, const pb::Message& message, std::vector<Field>& out);

/// Bytes without readable fields, such as a state, are compared by checksum.
std::string in_short(const std::string& bytes) {
  const auto sum =
      ::crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size()));
  return fmt::format("{} bytes, CRC-32 {:08x}", bytes.size(), sum);
}

/// One value of a field; `index` within a repeated field, else -1.
void add_value(const std::string& name, const pb::Message& message,
               const pb::FieldDescriptor& field, int index, std::vector<Field>& out) {
  const pb::Reflection& at = *message.GetReflection();
  const bool many = index >= 0;
  const auto number = [&](double value) {
    out.push_back({name, Number{Quantity::kNumber, value}});
  };
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_MESSAGE:
      return add_fields(
          name + ".",
          many ? at.GetRepeatedMessage(message, &field, index) : at.GetMessage(message, &field),
          out);
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
      return number(many ? at.GetRepeatedDouble(message, &field, index)
                         : at.GetDouble(message, &field));
    case pb::FieldDescriptor::CPPTYPE_FLOAT:
      return number(many ? at.GetRepeatedFloat(message, &field, index)
                         : at.GetFloat(message, &field));
    default:
      break;
  }
  std::string text;
  if (field.type() == pb::FieldDescriptor::TYPE_BYTES) {
    text = in_short(many ? at.GetRepeatedString(message, &field, index)
                         : at.GetString(message, &field));
  } else {
    pb::TextFormat::PrintFieldValueToString(message, &field, index, &text);
  }
  out.push_back({name, text});
}

void add_fields(const std::string& prefix, const pb::Message& message, std::vector<Field>& out) {
  std::vector<const pb::FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  for (const pb::FieldDescriptor* field : fields) {
    const std::string name = prefix + field->name();
    if (!field->is_repeated()) {
      add_value(name, message, *field, -1, out);
      continue;
    }
    const int size = message.GetReflection()->FieldSize(message, field);
    for (int i = 0; i < size; ++i) {
      add_value(fmt::format("{}[{}]", name, i), message, *field, i, out);
    }
  }
}

/// Request type of a method; null = unknown method.
const pb::Descriptor* request_type(const v1::JournalWire& wire) {
  if (wire.kind() == v1::WIRE_KIND_WEB) return v1::ViewerRequest::descriptor();
  // "/aprsim.v1.ControlService/Pause"
  std::string name = wire.method().substr(wire.method().starts_with('/') ? 1 : 0);
  for (char& c : name) c = c == '/' ? '.' : c;
  const auto* method = v1::PauseRequest::descriptor()->file()->pool()->FindMethodByName(name);
  return method == nullptr ? nullptr : method->input_type();
}

/// The kind of a page's request.
std::string page_request(const v1::JournalWire& wire) {
  v1::ViewerRequest request;
  if (!request.ParseFromString(wire.data())) return "unreadable";
  const auto* body = v1::ViewerRequest::descriptor()->FindOneofByName("body");
  const auto* field = request.GetReflection()->GetOneofFieldDescriptor(request, body);
  return field == nullptr ? "nothing" : field->name();
}

std::string call_name(const v1::JournalWire& wire) {
  if (wire.kind() == v1::WIRE_KIND_WEB) return "page's " + page_request(wire);
  return wire.method().substr(wire.method().rfind('/') + 1);
}

Action call_action(const WireRecord& record) {
  const v1::JournalWire& wire = record.wire;
  Action action{.kind = call_name(wire), .time_s = record.time_s};
  if (const pb::Descriptor* type = request_type(wire)) {
    const pb::Message* prototype = pb::MessageFactory::generated_factory()->GetPrototype(type);
    const std::unique_ptr<pb::Message> message(prototype->New());
    if (message->ParseFromString(wire.data())) {
      add_fields("", *message, action.fields);
      // A page numbers its requests.
      if (wire.kind() == v1::WIRE_KIND_WEB) {
        std::erase_if(action.fields, [](const Field& field) { return field.name == "id"; });
      }
      return action;
    }
  }
  if (!wire.data().empty()) {
    std::string hex;
    for (const char byte : wire.data())
      hex += fmt::format("{:02x}", static_cast<std::uint8_t>(byte));
    action.fields.push_back({"bytes", hex});
  }
  return action;
}

}  // namespace

WireActions call_actions(const Records& records) {
  WireActions out;
  for (const WireRecord* record : records) {
    if (record->wire.content() != v1::WIRE_CONTENT_RECEIVED) continue;
    Action action = call_action(*record);
    // The number of manual steps is arbitrary, and a page's subscriptions command nothing.
    if (action.kind == "Step" || action.kind == "page's step" || action.kind == "page's watch" ||
        action.kind == "page's authenticate") {
      ++out.polls;
    } else {
      out.actions.push_back(std::move(action));
    }
  }
  return out;
}

}  // namespace aprsim::trace
