#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include <Eigen/Core>

#if defined(__GNUC__) && !defined(__clang__)
// No such vector crosses the boundary of this program.
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace aprsim::render {

/// Eight numbers side by side, as vector registers hold them; operators act by lane, comparisons
/// make masks, and ?: selects by a mask. The bits are the same on all processors.
using Vec8f [[gnu::vector_size(32), gnu::aligned(32)]] = float;
using Vec8i [[gnu::vector_size(32), gnu::aligned(32)]] = int;
using Vec8u [[gnu::vector_size(32), gnu::aligned(32)]] = std::uint32_t;
using Mask8 = Vec8i;  ///< -1 where it holds, else 0
inline constexpr int kLanes = 8;

inline Vec8f load(const float* from) {
  Vec8f out;
  std::memcpy(&out, from, sizeof out);
  return out;
}
inline void store(float* to, const Vec8f& x) { std::memcpy(to, &x, sizeof x); }
inline Vec8f broadcast(float x) { return Vec8f{x, x, x, x, x, x, x, x}; }
inline Vec8i broadcast(int x) { return Vec8i{x, x, x, x, x, x, x, x}; }
inline Vec8f max(const Vec8f& x, const Vec8f& y) { return x > y ? x : y; }
inline Vec8f min(const Vec8f& x, const Vec8f& y) { return x < y ? x : y; }
inline Vec8f abs(const Vec8f& x) { return max(x, -x); }
inline Vec8f clamp(const Vec8f& x, float low, float high) {
  return min(max(x, broadcast(low)), broadcast(high));
}
inline Vec8i clamp(const Vec8i& x, int low, int high) {
  const Vec8i l = broadcast(low), h = broadcast(high);
  const Vec8i above = x > l ? x : l;
  return above < h ? above : h;
}
inline Vec8f sqrt(const Vec8f& x) {
  Eigen::Array<float, kLanes, 1> lanes;
  std::memcpy(lanes.data(), &x, sizeof x);
  lanes = lanes.sqrt();
  return load(lanes.data());
}
/// Towards zero; the numbers are within the range of int.
inline Vec8i truncate(const Vec8f& x) { return __builtin_convertvector(x, Vec8i); }
inline Vec8f to_float(const Vec8i& x) { return __builtin_convertvector(x, Vec8f); }
/// The nearest whole number, halves away from zero.
inline Vec8f round(const Vec8f& x) {
  const Vec8f half = x < 0 ? broadcast(-0.5F) : broadcast(0.5F);
  return to_float(truncate(x + half));
}
inline bool any(const Mask8& mask) {
  std::uint64_t parts[4];
  std::memcpy(parts, &mask, sizeof parts);
  return (parts[0] | parts[1] | parts[2] | parts[3]) != 0;
}

/// Eight vectors of three components, one a lane.
struct Vector3x8 {
  Vec8f x, y, z;

  static Vector3x8 broadcast(const Eigen::Vector3f& v) {
    return {render::broadcast(v.x()), render::broadcast(v.y()), render::broadcast(v.z())};
  }
  [[nodiscard]] Vec8f dot(const Vector3x8& o) const { return x * o.x + y * o.y + z * o.z; }
  [[nodiscard]] Vec8f norm() const { return sqrt(dot(*this)); }
  [[nodiscard]] Vector3x8 normalized() const { return *this * (1 / norm()); }

  friend Vector3x8 operator+(const Vector3x8& a, const Vector3x8& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend Vector3x8 operator-(const Vector3x8& a, const Vector3x8& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend Vector3x8 operator*(const Vector3x8& a, const Vec8f& s) {
    return {a.x * s, a.y * s, a.z * s};
  }
  friend Vector3x8 operator*(const Eigen::Matrix3f& m, const Vector3x8& v) {
    return {m(0, 0) * v.x + m(0, 1) * v.y + m(0, 2) * v.z,
            m(1, 0) * v.x + m(1, 1) * v.y + m(1, 2) * v.z,
            m(2, 0) * v.x + m(2, 1) * v.y + m(2, 2) * v.z};
  }
};

}  // namespace aprsim::render
