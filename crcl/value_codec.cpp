#include "crcl/value_codec.hpp"

#include "crcl/text.hpp"

namespace aprsim::crcl {
namespace {

constexpr double kLeastLength = 1e-6;
constexpr double kLeastSine = 0.1;

double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector scaled(const Vector& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
Vector minus(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// hypot, because a square could overflow.
double length(const Vector& a) { return std::hypot(a.x, a.y, a.z); }

std::string describe(const Vector& a) {
  std::string text;
  for (const double component : {a.x, a.y, a.z}) {
    if (!text.empty()) text += ' ';
    append_double(text, component);
  }
  return text;
}

tl::unexpected<Error> bad_axis(const char* element, const Vector& axis, const char* expected) {
  Error error;
  error.kind = ErrorKind::kBadValue;
  error.element = element;
  error.value = describe(axis);
  error.expected = expected;
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace

Result<Axes> orthonormal_axes(const Pose& pose) {
  const double z_length = length(pose.z_axis);
  const double x_length = length(pose.x_axis);
  constexpr const char* kNeedsLength = "expected a direction, the vector has no usable length";
  if (!std::isfinite(z_length) || z_length < kLeastLength) {
    return bad_axis("ZAxis", pose.z_axis, kNeedsLength);
  }
  if (!std::isfinite(x_length) || x_length < kLeastLength) {
    return bad_axis("XAxis", pose.x_axis, kNeedsLength);
  }
  const Vector z = scaled(pose.z_axis, 1 / z_length);
  const Vector x_raw = scaled(pose.x_axis, 1 / x_length);
  const Vector x_across = minus(x_raw, scaled(z, dot(x_raw, z)));
  const double sine = length(x_across);
  if (sine < kLeastSine) {
    return bad_axis("XAxis", pose.x_axis, "expected a direction across the ZAxis, it is parallel");
  }
  const Vector x = scaled(x_across, 1 / sine);
  return Axes{x, cross(z, x), z};
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

void write_point(ElementWriter& out, std::string_view name, const Vector& point) {
  out.open(name);
  out.number("X", point.x);
  out.number("Y", point.y);
  out.number("Z", point.z);
  out.close(name);
}

void write_vector(ElementWriter& out, std::string_view name, const Vector& vector) {
  out.open(name);
  out.number("I", vector.x);
  out.number("J", vector.y);
  out.number("K", vector.z);
  out.close(name);
}

void write_pose_elements(ElementWriter& out, const Pose& pose) {
  write_point(out, "Point", pose.point);
  write_vector(out, "XAxis", pose.x_axis);
  write_vector(out, "ZAxis", pose.z_axis);
}

void write_tolerance(ElementWriter& out, std::string_view name, const PoseTolerance& tolerance) {
  out.open(name);
  write_optional(out, "XPointTolerance", tolerance.x_point);
  write_optional(out, "YPointTolerance", tolerance.y_point);
  write_optional(out, "ZPointTolerance", tolerance.z_point);
  write_optional(out, "XAxisTolerance", tolerance.x_axis);
  write_optional(out, "ZAxisTolerance", tolerance.z_axis);
  out.close(name);
}

void write_joint_tolerances(ElementWriter& out, std::string_view name,
                            const std::vector<JointTolerance>& tolerances) {
  out.open(name);
  for (const JointTolerance& setting : tolerances) {
    out.open("Setting");
    out.integer("JointNumber", setting.joint);
    out.number("JointPositionTolerance", setting.tolerance);
    out.close("Setting");
  }
  out.close(name);
}

void write_parameter(ElementWriter& out, std::string_view name, const ParameterSetting& setting) {
  out.open(name);
  out.text("ParameterName", setting.name);
  out.text("ParameterValue", setting.value);
  out.close(name);
}

void write_parameters(ElementWriter& out, std::string_view name,
                      const std::vector<ParameterSetting>& settings) {
  for (const ParameterSetting& setting : settings) write_parameter(out, name, setting);
}

void write_optional(ElementWriter& out, std::string_view name, const std::optional<double>& value) {
  if (value) out.number(name, *value);
}

void write_optional(ElementWriter& out, std::string_view name, const std::optional<int>& value) {
  if (value) out.integer(name, *value);
}

void write_optional(ElementWriter& out, std::string_view name,
                    const std::optional<std::int64_t>& value) {
  if (value) out.integer(name, *value);
}

void write_optional(ElementWriter& out, std::string_view name, const std::optional<bool>& value) {
  if (value) out.flag(name, *value);
}

void write_optional(ElementWriter& out, std::string_view name,
                    const std::optional<std::string>& value) {
  if (value) out.text(name, *value);
}

}  // namespace aprsim::crcl
