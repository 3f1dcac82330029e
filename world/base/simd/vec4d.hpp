#pragma once

#include <cmath>

#include <Eigen/Core>

#if defined(__GNUC__) && !defined(__clang__)
// No such vector crosses the boundary of this program.
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace aprsim::physics {

/// Four numbers side by side, as vector registers hold them. Operations act on all four lanes, with
/// the same bits on all processors. (GCC and Clang vector extension: operators act by
/// lane, comparisons make masks, and ?: selects by a mask. As a template argument the type would
/// lose its alignment.)
using Vec4d [[gnu::vector_size(32), gnu::aligned(32)]] = double;
using Mask4 = decltype(Vec4d{} < Vec4d{});
inline constexpr int kLanes = 4;

inline Vec4d broadcast(double x) { return Vec4d{x, x, x, x}; }
inline Vec4d sqrt(const Vec4d& x) {
  Vec4d out;
  for (int i = 0; i < kLanes; ++i) out[i] = std::sqrt(x[i]);
  return out;
}
inline Vec4d max(const Vec4d& x, const Vec4d& y) { return x > y ? x : y; }
inline Vec4d min(const Vec4d& x, const Vec4d& y) { return x < y ? x : y; }
inline Vec4d abs(const Vec4d& x) { return max(x, -x); }
/// Clamped to between -limit and limit.
inline Vec4d clamp_abs(const Vec4d& x, const Vec4d& limit) { return min(max(x, -limit), limit); }
/// 1 / x, and 0 where x is not positive.
inline Vec4d inverse_or_zero(const Vec4d& x) { return x > 0 ? 1 / x : broadcast(0); }
inline bool any(const Mask4& mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }
inline bool all(const Mask4& mask) { return (mask[0] & mask[1] & mask[2] & mask[3]) != 0; }
inline double horizontal_add(const Vec4d& x) { return (x[0] + x[1]) + (x[2] + x[3]); }
/// The sums of four vectors, each in the same order of additions.
inline Vec4d horizontal_add(const Vec4d& a, const Vec4d& b, const Vec4d& c, const Vec4d& d) {
  const Vec4d ab =
      __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Vec4d cd =
      __builtin_shufflevector(c, d, 0, 4, 2, 6) + __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}
inline double horizontal_max(const Vec4d& x) {
  return std::fmax(std::fmax(x[0], x[1]), std::fmax(x[2], x[3]));
}

/// Four vectors of three components, one a lane.
struct Vector3x4 {
  Vec4d x, y, z;

  static Vector3x4 broadcast(const Eigen::Vector3d& v) {
    return {physics::broadcast(v.x()), physics::broadcast(v.y()), physics::broadcast(v.z())};
  }
  static Vector3x4 zero() {
    return {physics::broadcast(0), physics::broadcast(0), physics::broadcast(0)};
  }
  void set(int lane, const Eigen::Vector3d& v) {
    x[lane] = v.x();
    y[lane] = v.y();
    z[lane] = v.z();
  }
  [[nodiscard]] Eigen::Vector3d at(int lane) const { return {x[lane], y[lane], z[lane]}; }
};
inline Vector3x4 operator+(const Vector3x4& a, const Vector3x4& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vector3x4 operator-(const Vector3x4& a, const Vector3x4& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vector3x4 operator*(const Vec4d& s, const Vector3x4& a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline Vec4d dot(const Vector3x4& a, const Vector3x4& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vector3x4 cross(const Vector3x4& a, const Vector3x4& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace aprsim::physics
