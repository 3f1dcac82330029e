#include "server/journal/utf8_strings.hpp"

#include <string>
#include <vector>

#include "world/base/utf8.hpp"

namespace aprsim::server::journal {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

void make_utf8(Message& message, const Reflection& reflection, const FieldDescriptor& field) {
  std::string scratch;
  if (!field.is_repeated()) {
    const std::string& text = reflection.GetStringReference(message, &field, &scratch);
    if (!utf8::is_valid(text)) reflection.SetString(&message, &field, utf8::valid(text));
    return;
  }
  for (int i = 0; i < reflection.FieldSize(message, &field); ++i) {
    const std::string& text = reflection.GetRepeatedStringReference(message, &field, i, &scratch);
    if (!utf8::is_valid(text)) reflection.SetRepeatedString(&message, &field, i, utf8::valid(text));
  }
}

}  // namespace

void make_utf8(Message& message) {
  const Reflection& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    if (field->type() == FieldDescriptor::TYPE_STRING) {
      make_utf8(message, reflection, *field);
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE && !field->is_map()) {
      if (!field->is_repeated()) {
        make_utf8(*reflection.MutableMessage(&message, field));
        continue;
      }
      for (int i = 0; i < reflection.FieldSize(message, field); ++i) {
        make_utf8(*reflection.MutableRepeatedMessage(&message, field, i));
      }
    }
  }
}

}  // namespace aprsim::server::journal
