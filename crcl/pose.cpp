#include "crcl/pose.hpp"

#include <cmath>

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

}  // namespace aprsim::crcl
