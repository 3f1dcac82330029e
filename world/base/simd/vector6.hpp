#pragma once

#include <cstring>

#include <Eigen/Core>

#include "world/base/simd/vec4d.hpp"

namespace aprsim::physics {

/// Six numbers in registers, such as a spatial velocity or impulse. They are stored in the same two
/// pieces as they are loaded: a register that is loaded over several earlier stores waits for them.
struct Vector6 {
  using Pair [[gnu::vector_size(16), gnu::aligned(16)]] = double;
  Vec4d head;
  Pair tail;

  static Vector6 load(const double* from) {
    Vector6 out;
    std::memcpy(&out.head, from, sizeof out.head);
    std::memcpy(&out.tail, from + kLanes, sizeof out.tail);
    return out;
  }
  void store(double* to) const {
    std::memcpy(to, &head, sizeof head);
    std::memcpy(to + kLanes, &tail, sizeof tail);
  }
  /// With the lower or the upper half of `tails` as tail.
  static Vector6 join(const Vec4d& head, const Vec4d& tails, bool upper) {
    return {head, upper ? __builtin_shufflevector(tails, tails, 2, 3)
                        : __builtin_shufflevector(tails, tails, 0, 1)};
  }
  static Vector6 zero() { return {broadcast(0), Pair{0, 0}}; }
  static Vector6 one() { return {broadcast(1), Pair{1, 1}}; }
  /// 1 at place `i`, 0 elsewhere.
  static Vector6 unit(int i) {
    Vector6 out = zero();
    if (i < kLanes) {
      out.head[i] = 1;
    } else {
      out.tail[i - kLanes] = 1;
    }
    return out;
  }
  [[nodiscard]] double operator[](int i) const { return i < kLanes ? head[i] : tail[i - kLanes]; }
};
inline Vector6 operator+(const Vector6& a, const Vector6& b) {
  return {a.head + b.head, a.tail + b.tail};
}
inline Vector6 operator-(const Vector6& a, const Vector6& b) {
  return {a.head - b.head, a.tail - b.tail};
}
inline Vector6 operator*(const Vector6& a, const Vector6& b) {
  return {a.head * b.head, a.tail * b.tail};
}
inline Vector6 operator*(double s, const Vector6& a) { return {s * a.head, s * a.tail}; }

/// Adds to column `k` of a block.
inline void add_column(const Vector6& column, Eigen::Matrix<double, 6, 6>& m, int k) {
  double* own = m.col(k).data();
  (Vector6::load(own) + column).store(own);
}

/// A matrix of 6 by 6 in registers, by columns.
struct Matrix6 {
  using Block = Eigen::Matrix<double, 6, 6>;

  static Matrix6 load(const Block& m) {
    Matrix6 out;
    for (int k = 0; k < 6; ++k) out.column[k] = Vector6::load(m.col(k).data());
    return out;
  }
  void store(Block& m) const {
    for (int k = 0; k < 6; ++k) column[k].store(m.col(k).data());
  }
  static Matrix6 zero() {
    Matrix6 out;
    for (Vector6& each : out.column) each = Vector6::zero();
    return out;
  }
  /// Product with the vector at address x.
  [[nodiscard]] Vector6 times(const double* x) const {
    Vector6 out = x[0] * column[0];
    for (int k = 1; k < 6; ++k) out = out + x[k] * column[k];
    return out;
  }
  void add_to(Block& m) const {
    for (int k = 0; k < 6; ++k) add_column(column[k], m, k);
  }

  Vector6 column[6];
};

}  // namespace aprsim::physics
