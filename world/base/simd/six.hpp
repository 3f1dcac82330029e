#pragma once

#include <cstring>

#include <Eigen/Core>

#include "world/base/simd/lanes.hpp"

namespace aprsim::physics {

/// Six numbers that stand in a row in memory, as of a body's velocity. What is written so is read
/// so: a register that is loaded over what several others have stored has to wait for them.
struct Six {
  using Pair [[gnu::vector_size(16), gnu::aligned(16)]] = double;
  Lanes head;
  Pair tail;

  static Six load(const double* from) {
    Six out;
    std::memcpy(&out.head, from, sizeof out.head);
    std::memcpy(&out.tail, from + kLanes, sizeof out.tail);
    return out;
  }
  void store(double* to) const {
    std::memcpy(to, &head, sizeof head);
    std::memcpy(to + kLanes, &tail, sizeof tail);
  }
  /// Halves of `tails`.
  static Six of(const Lanes& head, const Lanes& tails, bool second) {
    return {head, second ? __builtin_shufflevector(tails, tails, 2, 3)
                         : __builtin_shufflevector(tails, tails, 0, 1)};
  }
  static Six zero() { return {spread(0), Pair{0, 0}}; }
  /// 1 at one place.
  static Six unit(int i) {
    Six out = zero();
    if (i < kLanes) {
      out.head[i] = 1;
    } else {
      out.tail[i - kLanes] = 1;
    }
    return out;
  }
  [[nodiscard]] double operator[](int i) const { return i < kLanes ? head[i] : tail[i - kLanes]; }
};
inline Six operator+(const Six& a, const Six& b) { return {a.head + b.head, a.tail + b.tail}; }
inline Six operator-(const Six& a, const Six& b) { return {a.head - b.head, a.tail - b.tail}; }
inline Six operator*(const Six& a, const Six& b) { return {a.head * b.head, a.tail * b.tail}; }
inline Six operator*(double s, const Six& a) { return {s * a.head, s * a.tail}; }

/// Adds to a column of a block.
inline void add_column(const Six& column, Eigen::Matrix<double, 6, 6>& m, int k) {
  double* own = m.col(k).data();
  (Six::load(own) + column).store(own);
}

/// The columns of a block of 6 by 6, in registers.
struct SixColumns {
  using Block = Eigen::Matrix<double, 6, 6>;

  static SixColumns load(const Block& m) {
    SixColumns out;
    for (int k = 0; k < 6; ++k) out.of[k] = Six::load(m.col(k).data());
    return out;
  }
  void store(Block& m) const {
    for (int k = 0; k < 6; ++k) of[k].store(m.col(k).data());
  }
  static SixColumns zero() {
    SixColumns out;
    for (Six& column : out.of) column = Six::zero();
    return out;
  }
  /// Times the vector that stands at x.
  [[nodiscard]] Six times(const double* x) const {
    Six out = x[0] * of[0];
    for (int k = 1; k < 6; ++k) out = out + x[k] * of[k];
    return out;
  }
  void add_to(Block& m) const {
    for (int k = 0; k < 6; ++k) add_column(of[k], m, k);
  }

  Six of[6];
};

}  // namespace aprsim::physics
