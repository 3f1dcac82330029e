#include "world/physics/constraint/cholesky.hpp"

#include <cmath>
#include <utility>

namespace aprsim::physics {
namespace {

// Element by element, without fused operations, so that wide registers change no bit.
using Four [[gnu::vector_size(32), gnu::aligned(8), gnu::may_alias]] = double;

[[gnu::always_inline]] inline void subtract_by_four(double a, const double* x, double* y, int n) {
  int i = 0;
  for (; i + 4 <= n; i += 4) {
    *reinterpret_cast<Four*>(y + i) -= a * *reinterpret_cast<const Four*>(x + i);
  }
  for (; i < n; ++i) y[i] -= a * x[i];
}

using Subtract = void (*)(double, const double*, double*, int);

void subtract_plain(double a, const double* x, double* y, int n) { subtract_by_four(a, x, y, n); }

#ifdef __x86_64__
[[gnu::target("avx2")]] void subtract_wide(double a, const double* x, double* y, int n) {
  subtract_by_four(a, x, y, n);
}
// Chosen once, by the processor.
const Subtract kSubtract = __builtin_cpu_supports("avx2") ? subtract_wide : subtract_plain;
#else
const Subtract kSubtract = subtract_plain;
#endif

}  // namespace

void subtract(double a, const double* x, double* y, int n) { kSubtract(a, x, y, n); }

/// Left-looking, column by column (Golub & Van Loan, Matrix Computations, ch. 4.2).
void factorise(double* a, int n, std::ptrdiff_t stride) {
  for (int j = 0; j < n; ++j) {
    double* column = a + j * stride;
    for (int k = 0; k < j; ++k) {
      const double* other = a + k * stride;
      if (other[j] != 0) subtract(other[j], other + j, column + j, n - j);
    }
    const double scale = 1 / std::sqrt(column[j]);
    for (int i = j; i < n; ++i) column[i] *= scale;
  }
}

void solve_lower(const double* l, int n, std::ptrdiff_t stride, double* x) {
  for (int j = 0; j < n; ++j) {
    const double* column = l + j * stride;
    x[j] /= column[j];
    if (x[j] != 0) subtract(x[j], column + j + 1, x + j + 1, n - j - 1);
  }
}

void solve_lower_transposed(const double* l, int n, std::ptrdiff_t stride, double* x) {
  for (int j = n - 1; j >= 0; --j) {
    const double* column = l + j * stride;
    double below = 0;
    for (int i = j + 1; i < n; ++i) below += column[i] * x[i];
    x[j] = (x[j] - below) / column[j];
  }
}

/// Gaussian elimination with partial pivoting on both right sides at once (Golub & Van Loan,
/// ch. 3.4).
bool solve_two(double* a, int n, std::ptrdiff_t stride, double* right, double* other) {
  for (int k = 0; k < n; ++k) {
    double* column = a + k * stride;
    int pivot = k;
    for (int i = k + 1; i < n; ++i) {
      if (std::abs(column[i]) > std::abs(column[pivot])) pivot = i;
    }
    if (column[pivot] == 0) return false;
    if (pivot != k) {
      for (int c = 0; c < n; ++c) std::swap(a[c * stride + k], a[c * stride + pivot]);
      std::swap(right[k], right[pivot]);
      std::swap(other[k], other[pivot]);
    }
    // Column k of L, then what it takes from the columns and right sides after it.
    const int below = n - k - 1;
    const double scale = 1 / column[k];
    for (int i = k + 1; i < n; ++i) column[i] *= scale;
    for (int c = k + 1; c < n; ++c) {
      double* next = a + c * stride;
      if (next[k] != 0) subtract(next[k], column + k + 1, next + k + 1, below);
    }
    subtract(right[k], column + k + 1, right + k + 1, below);
    subtract(other[k], column + k + 1, other + k + 1, below);
  }
  // Back substitution, column by column.
  for (int k = n - 1; k >= 0; --k) {
    const double* column = a + k * stride;
    right[k] /= column[k];
    other[k] /= column[k];
    subtract(right[k], column, right, k);
    subtract(other[k], column, other, k);
  }
  return true;
}

}  // namespace aprsim::physics
