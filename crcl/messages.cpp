#include "crcl/messages.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include "crcl/document_codec.hpp"
#include "crcl/text.hpp"
#include "crcl/tree_writer.hpp"
#include "crcl/xml_writer.hpp"

// One walk for all messages: a field's JSON name is its element, and the JSON name of the member
// that a oneof has is the element's xsi:type.
namespace aprsim::crcl {
namespace {

namespace pb = google::protobuf;
using Field = pb::FieldDescriptor;

// An enumeration's words in the schema, in the order of its enumerators from 1.
struct Words {
  const pb::EnumDescriptor* type;
  std::span<const std::string_view> words;
};

std::span<const std::string_view> words_of(const pb::EnumDescriptor& type) {
  using std::string_view;
  static constexpr std::array<string_view, 3> kLengths{"meter", "millimeter", "inch"};
  static constexpr std::array<string_view, 2> kAngles{"radian", "degree"};
  static constexpr std::array<string_view, 3> kForces{"newton", "pound", "ounce"};
  static constexpr std::array<string_view, 2> kTorques{"newtonMeter", "footPound"};
  static constexpr std::array<string_view, 3> kStops{"Immediate", "Fast", "Normal"};
  static constexpr std::array<string_view, 4> kLimits{
      "OVER_MAX", "UNDER_MIN", "INCREASE_OVER_LIMIT", "DECREASE_BEYOND_LIMIT"};
  static constexpr std::array<string_view, 4> kStates{"CRCL_Done", "CRCL_Error", "CRCL_Working",
                                                      "CRCL_Ready"};
  static const std::array<Words, 7> kAll{{{v1::LengthUnit_descriptor(), kLengths},
                                          {v1::AngleUnit_descriptor(), kAngles},
                                          {v1::ForceUnit_descriptor(), kForces},
                                          {v1::TorqueUnit_descriptor(), kTorques},
                                          {v1::StopCondition_descriptor(), kStops},
                                          {v1::GuardLimit_descriptor(), kLimits},
                                          {v1::CommandState_descriptor(), kStates}}};
  const auto* found = std::ranges::find(kAll, &type, &Words::type);
  if (found == kAll.end()) throw std::logic_error("no words for " + type.full_name());
  return found->words;
}

bool is_kind(const Field& field) { return field.real_containing_oneof() != nullptr; }

const pb::OneofDescriptor* kind_of(const pb::Descriptor& type) {
  return type.real_oneof_decl_count() == 0 ? nullptr : type.oneof_decl(0);
}

// Writing.

void write_fields(const pb::Message& message, ElementWriter& out);

void write_element(std::string_view name, const pb::Message& message, ElementWriter& out) {
  const pb::OneofDescriptor* kinds = kind_of(*message.GetDescriptor());
  const Field* kind =
      kinds == nullptr ? nullptr : message.GetReflection()->GetOneofFieldDescriptor(message, kinds);
  if (kind == nullptr) {
    out.open(name);
  } else {
    out.open(name, kind->json_name());
  }
  write_fields(message, out);
  out.close(name);
}

void write_value(const pb::Message& message, const Field& field, ElementWriter& out) {
  const pb::Reflection& values = *message.GetReflection();
  const std::string& name = field.json_name();
  switch (field.cpp_type()) {
    case Field::CPPTYPE_MESSAGE:
      return write_element(name, values.GetMessage(message, &field), out);
    case Field::CPPTYPE_DOUBLE:
      return out.number(name, values.GetDouble(message, &field));
    case Field::CPPTYPE_INT32:
      return out.integer(name, values.GetInt32(message, &field));
    case Field::CPPTYPE_INT64:
      return out.integer(name, values.GetInt64(message, &field));
    case Field::CPPTYPE_BOOL:
      return out.flag(name, values.GetBool(message, &field));
    case Field::CPPTYPE_STRING:
      return out.text(name, values.GetString(message, &field));
    case Field::CPPTYPE_ENUM: {
      const auto words = words_of(*field.enum_type());
      const int value = values.GetEnumValue(message, &field);
      if (value > 0 && value <= static_cast<int>(words.size())) {
        out.text(name, words[static_cast<std::size_t>(value - 1)]);
      }
      return;
    }
    default:
      throw std::logic_error("no element for " + field.full_name());
  }
}

// The order of the declarations is the schema's.
void write_fields(const pb::Message& message, ElementWriter& out) {
  const pb::Reflection& values = *message.GetReflection();
  const pb::Descriptor& type = *message.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const Field& field = *type.field(i);
    if (field.is_repeated()) {
      for (int k = 0; k < values.FieldSize(message, &field); ++k) {
        write_element(field.json_name(), values.GetRepeatedMessage(message, &field, k), out);
      }
    } else if (values.HasField(message, &field)) {
      if (is_kind(field)) {
        write_fields(values.GetMessage(message, &field), out);
      } else {
        write_value(message, field, out);
      }
    }
  }
}

template <typename Message>
std::string document_of(std::string_view root, const Message& message) {
  XmlWriter out;
  write_element(root, message, out);
  return std::move(out).document();
}

template <typename Message>
XmlNode tree_of(std::string_view root, const Message& message) {
  TreeWriter out;
  write_element(root, message, out);
  return std::move(out).root();
}

// Reading.

const Field* find(const pb::Descriptor& type, std::string_view name, bool kind) {
  for (int i = 0; i < type.field_count(); ++i) {
    const Field* field = type.field(i);
    if (is_kind(*field) == kind && field->json_name() == name) return field;
  }
  return nullptr;
}

// Position of a reader in the document.
struct Place {
  const XmlNode* node;
  const Place* parent;

  [[nodiscard]] std::string path() const {
    return parent == nullptr ? node->name : parent->path() + "/" + node->name;
  }
};

class MessageReader {
 public:
  void read(const Place& place, pb::Message& message) {
    pb::Message* kind = kind_in(place, message);
    for (const XmlNode& child : place.node->children) {
      if (fault_) return;
      const Place inside{&child, &place};
      const Field* field = find(*message.GetDescriptor(), child.name, false);
      if (field != nullptr) {
        read_field(inside, message, *field);
      } else if (kind != nullptr) {
        field = find(*kind->GetDescriptor(), child.name, false);
        if (field != nullptr) read_field(inside, *kind, *field);
      }
    }
  }

  [[nodiscard]] std::optional<Error>& fault() { return fault_; }

 private:
  // The message whose fields stand in the element by its xsi:type; null where there is none.
  pb::Message* kind_in(const Place& place, pb::Message& message) {
    const pb::Descriptor& type = *message.GetDescriptor();
    if (kind_of(type) == nullptr) return nullptr;
    const std::string& given = place.node->type;
    const Field* kind = find(type, given, true);
    if (kind != nullptr) return message.GetReflection()->MutableMessage(&message, kind);
    // A pose may be a plain PoseType; other abstract types need an xsi:type.
    if (&type == v1::Pose::descriptor() && (given.empty() || given == "PoseType")) return nullptr;
    fail(place, given,
         given.empty() ? "xsi:type missing" : "unknown xsi:type, expected one of the schema",
         ErrorKind::kMalformed);
    return nullptr;
  }

  void read_field(const Place& place, pb::Message& message, const Field& field) {
    const pb::Reflection& values = *message.GetReflection();
    if (field.is_repeated()) return read(place, *values.AddMessage(&message, &field));
    if (values.HasField(message, &field)) return;
    const std::string& text = place.node->text;
    switch (field.cpp_type()) {
      case Field::CPPTYPE_MESSAGE:
        return read(place, *values.MutableMessage(&message, &field));
      case Field::CPPTYPE_DOUBLE:
        if (const auto value = parsed(place, parse_double(text), "expected a number")) {
          values.SetDouble(&message, &field, *value);
        }
        return;
      case Field::CPPTYPE_INT32:
        if (const auto value = parsed(place, parse_int(text), "expected an integer")) {
          values.SetInt32(&message, &field, *value);
        }
        return;
      case Field::CPPTYPE_INT64:
        if (const auto value = parsed(place, parse_long(text), "expected an integer")) {
          values.SetInt64(&message, &field, *value);
        }
        return;
      case Field::CPPTYPE_BOOL:
        if (const auto value = parsed(place, parse_bool(text), "expected true or false")) {
          values.SetBool(&message, &field, *value);
        }
        return;
      case Field::CPPTYPE_STRING:
        return values.SetString(&message, &field, text);
      case Field::CPPTYPE_ENUM: {
        const auto words = words_of(*field.enum_type());
        const auto word = std::ranges::find(words, trim(text));
        if (word != words.end()) {
          return values.SetEnumValue(&message, &field, static_cast<int>(word - words.begin()) + 1);
        }
        std::string expected = "expected";
        for (const std::string_view known : words) expected += " " + std::string(known);
        return fail(place, text, std::move(expected));
      }
      default:
        throw std::logic_error("no element for " + field.full_name());
    }
  }

  template <typename T>
  std::optional<T> parsed(const Place& place, std::optional<T> value, const char* expected) {
    if (!value) fail(place, place.node->text, expected);
    return value;
  }

  void fail(const Place& place, std::string_view value, std::string expected,
            ErrorKind kind = ErrorKind::kBadValue) {
    if (fault_) return;
    fault_.emplace();
    fault_->kind = kind;
    fault_->element = place.path();
    fault_->value = shorten(trim(value));
    fault_->expected = std::move(expected);
  }

  std::optional<Error> fault_;
};

template <typename Message>
Result<Message> message_of(const XmlNode& root, std::string_view root_name) {
  MessageReader reader;
  Message message;
  if (root.name != root_name) {
    Error error;
    error.element = shorten(root.name);
    error.expected = "expected the root element " + std::string(root_name);
    return tl::unexpected<Error>(std::move(error));
  }
  reader.read({&root, nullptr}, message);
  if (reader.fault()) return tl::unexpected<Error>(std::move(*reader.fault()));
  return message;
}

template <typename Message>
Result<Message> message_of(std::string_view document, std::size_t max_bytes,
                           std::string_view root_name) {
  const Result<XmlNode> root = parse_xml(document, {.max_bytes = max_bytes});
  if (!root) return tl::unexpected<Error>(root.error());
  return message_of<Message>(*root, root_name);
}

// A document that was written here can always be read.
template <typename Message, typename Value>
Message message_of_value(std::string_view root_name, const Value& value,
                         void (*write)(ElementWriter&, const Value&)) {
  TreeWriter out;
  write(out, value);
  return message_of<Message>(std::move(out).root(), root_name).value();
}

}  // namespace

Result<v1::CommandInstance> command_message(std::string_view document, std::size_t max_bytes) {
  Result<v1::CommandInstance> message =
      message_of<v1::CommandInstance>(document, max_bytes, kCommandRoot);
  if (message && !message->has_command()) {
    Error error;
    error.element = std::string(kCommandRoot) + "/CRCLCommand";
    error.expected = "missing";
    return tl::unexpected<Error>(std::move(error));
  }
  return message;
}

Result<v1::Program> program_message(std::string_view document, std::size_t max_bytes) {
  return message_of<v1::Program>(document, max_bytes, kProgramRoot);
}

Result<v1::Status> status_message(std::string_view document, std::size_t max_bytes) {
  return message_of<v1::Status>(document, max_bytes, kStatusRoot);
}

std::string to_document(const v1::CommandInstance& message) {
  return document_of(kCommandRoot, message);
}
std::string to_document(const v1::Program& message) { return document_of(kProgramRoot, message); }
std::string to_document(const v1::Status& message) { return document_of(kStatusRoot, message); }

v1::CommandInstance to_message(const CommandInstance& instance) {
  return message_of_value<v1::CommandInstance>(kCommandRoot, instance, write_command_instance);
}
v1::Program to_message(const Program& program) {
  return message_of_value<v1::Program>(kProgramRoot, program, write_program);
}
v1::Status to_message(const Status& status) {
  return message_of_value<v1::Status>(kStatusRoot, status, write_status);
}

Result<CommandInstance> from_message(const v1::CommandInstance& message) {
  return read_command_instance(tree_of(kCommandRoot, message));
}
Result<Program> from_message(const v1::Program& message) {
  return read_program(tree_of(kProgramRoot, message));
}
Result<Status> from_message(const v1::Status& message) {
  return read_status(tree_of(kStatusRoot, message));
}

}  // namespace aprsim::crcl
