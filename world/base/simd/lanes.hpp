#pragma once

#include <cmath>

#include <Eigen/Core>

#if defined(__GNUC__) && !defined(__clang__)
// Nothing outside of this program is handed such vectors.
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace aprsim::physics {

/// Four numbers side by side, as vector registers hold them: what is computed of one is computed of
/// all four. The same bits on all processors. (Vectors of GCC and Clang: they take operators, and
/// comparisons make masks, by which ?: chooses. Aligned for what is compiled for wider registers;
/// as an argument of a template the type would lose that.)
using Lanes [[gnu::vector_size(32), gnu::aligned(32)]] = double;
using LaneMask = decltype(Lanes{} < Lanes{});
inline constexpr int kLanes = 4;

inline Lanes spread(double x) { return Lanes{x, x, x, x}; }
inline Lanes root(const Lanes& x) {
  Lanes out;
  for (int i = 0; i < kLanes; ++i) out[i] = std::sqrt(x[i]);
  return out;
}
inline Lanes greater(const Lanes& x, const Lanes& y) { return x > y ? x : y; }
inline Lanes lesser(const Lanes& x, const Lanes& y) { return x < y ? x : y; }
inline Lanes size_of(const Lanes& x) { return greater(x, -x); }
/// Between -most and most.
inline Lanes bounded(const Lanes& x, const Lanes& most) { return lesser(greater(x, -most), most); }
/// 1 / x, and 0 of what is not positive.
inline Lanes inverse_or_zero(const Lanes& x) { return x > 0 ? 1 / x : spread(0); }
inline bool any(const LaneMask& mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }
inline bool all(const LaneMask& mask) { return (mask[0] & mask[1] & mask[2] & mask[3]) != 0; }
inline double sum(const Lanes& x) { return (x[0] + x[1]) + (x[2] + x[3]); }
/// Of each of four, in the same order of additions.
inline Lanes sums(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d) {
  const Lanes ab =
      __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Lanes cd =
      __builtin_shufflevector(c, d, 0, 4, 2, 6) + __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}
inline double greatest(const Lanes& x) {
  return std::fmax(std::fmax(x[0], x[1]), std::fmax(x[2], x[3]));
}

/// Four vectors.
struct Lanes3 {
  Lanes x, y, z;

  static Lanes3 of(const Eigen::Vector3d& v) {
    return {spread(v.x()), spread(v.y()), spread(v.z())};
  }
  static Lanes3 zero() { return {spread(0), spread(0), spread(0)}; }
  void set(int lane, const Eigen::Vector3d& v) {
    x[lane] = v.x();
    y[lane] = v.y();
    z[lane] = v.z();
  }
  [[nodiscard]] Eigen::Vector3d at(int lane) const { return {x[lane], y[lane], z[lane]}; }
};
inline Lanes3 operator+(const Lanes3& a, const Lanes3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Lanes3 operator-(const Lanes3& a, const Lanes3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Lanes3 operator*(const Lanes& s, const Lanes3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Lanes dot(const Lanes3& a, const Lanes3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace aprsim::physics
