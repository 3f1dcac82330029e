#include "crcl/fields.hpp"

#include <cmath>
#include <utility>

#include "crcl/text.hpp"

namespace aprsim::crcl {
namespace {

const XmlNode& empty_node() {
  static const XmlNode node;
  return node;
}

constexpr const char* kNumber = "expected a finite number";
constexpr const char* kInteger = "expected an integer";
constexpr const char* kMissing = "missing";

}  // namespace

Fields Fields::child(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) {
    fail(name, "", kMissing);
    return {empty_node(), *slot_, this};
  }
  return {*found, *slot_, this};
}

std::vector<Fields> Fields::children(std::string_view name) const {
  std::vector<Fields> found;
  for (const XmlNode& node : node_->children) {
    if (node.name == name) found.push_back(Fields(node, *slot_, this));
  }
  return found;
}

std::optional<double> Fields::optional_number(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) return std::nullopt;
  const std::optional<double> value = parse_double(found->text);
  if (value && std::isfinite(*value)) return value;
  fail(name, found->text, kNumber);
  return std::nullopt;
}

double Fields::number(std::string_view name) const {
  if (!has(name)) fail(name, "", kMissing);
  return optional_number(name).value_or(0);
}

std::optional<int> Fields::optional_integer(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) return std::nullopt;
  const std::optional<int> value = parse_int(found->text);
  if (!value) fail(name, found->text, kInteger);
  return value;
}

int Fields::integer(std::string_view name) const {
  if (!has(name)) fail(name, "", kMissing);
  return optional_integer(name).value_or(0);
}

std::optional<std::int64_t> Fields::optional_long(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) return std::nullopt;
  const std::optional<std::int64_t> value = parse_long(found->text);
  if (!value) fail(name, found->text, kInteger);
  return value;
}

std::optional<bool> Fields::optional_flag(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) return std::nullopt;
  const std::optional<bool> value = parse_bool(found->text);
  if (!value) fail(name, found->text, "expected true or false");
  return value;
}

bool Fields::flag(std::string_view name) const { return optional_flag(name).value_or(false); }

std::optional<std::string> Fields::optional_text(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) return std::nullopt;
  return found->text;
}

std::string Fields::text(std::string_view name) const {
  if (!has(name)) fail(name, "", kMissing);
  return optional_text(name).value_or("");
}

void Fields::fail(std::string_view name, std::string_view value, std::string expected,
                  ErrorKind kind) const {
  if (slot_->has_value()) return;
  Error error;
  error.kind = kind;
  error.element = path();
  if (!name.empty()) error.element += "/" + std::string(name);
  error.value = shorten(trim(value));
  error.expected = std::move(expected);
  *slot_ = std::move(error);
}

std::string Fields::path() const {
  if (parent_ == nullptr) return node_->type.empty() ? node_->name : node_->type;
  return parent_->path() + "/" + node_->name;
}

Vector read_point(const Fields& point) {
  return {point.number("X"), point.number("Y"), point.number("Z")};
}

Vector read_vector(const Fields& vector) {
  return {vector.number("I"), vector.number("J"), vector.number("K")};
}

Pose read_pose(const Fields& pose) {
  return {read_point(pose.child("Point")), read_vector(pose.child("XAxis")),
          read_vector(pose.child("ZAxis"))};
}

PoseTolerance read_pose_tolerance(const Fields& tolerance) {
  return {tolerance.optional_number("XPointTolerance"),
          tolerance.optional_number("YPointTolerance"),
          tolerance.optional_number("ZPointTolerance"), tolerance.optional_number("XAxisTolerance"),
          tolerance.optional_number("ZAxisTolerance")};
}

std::vector<JointTolerance> read_joint_tolerances(const Fields& tolerances) {
  std::vector<JointTolerance> values;
  for (const Fields& setting : tolerances.children("Setting")) {
    values.push_back({setting.integer("JointNumber"), setting.number("JointPositionTolerance")});
  }
  return values;
}

ParameterSetting read_parameter(const Fields& setting) {
  return {std::string(trim(setting.text("ParameterName"))),
          std::string(trim(setting.text("ParameterValue")))};
}

std::vector<ParameterSetting> read_parameters(const Fields& parent, std::string_view name) {
  std::vector<ParameterSetting> settings;
  for (const Fields& setting : parent.children(name)) settings.push_back(read_parameter(setting));
  return settings;
}

}  // namespace aprsim::crcl
