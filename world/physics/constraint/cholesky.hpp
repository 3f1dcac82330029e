#pragma once

#include <cstddef>

/// Small dense systems, columns `stride` apart. Results do not depend on the processor.
namespace aprsim::physics {

/// y -= a x, n numbers each.
void subtract(double a, const double* x, double* y, int n);

/// Lower triangle L of a = L L^T in place, and solutions with it.
void factorise(double* a, int n, std::ptrdiff_t stride);
void solve_lower(const double* l, int n, std::ptrdiff_t stride, double* x);
void solve_lower_transposed(const double* l, int n, std::ptrdiff_t stride, double* x);

/// Solves a x = right for two right sides, in place, whatever a; rows are exchanged. False when a
/// is singular.
[[nodiscard]] bool solve_two(double* a, int n, std::ptrdiff_t stride, double* right, double* other);

}  // namespace aprsim::physics
