#pragma once

#include <cmath>
#include <random>

#include <Eigen/Geometry>

#include "tests/unit/world/physics/constraint/random_problems.hpp"

namespace aprsim::physics {

/// Bodies in layers, as in a heap: each lies on the ground or on up to four of the layer below, on
/// faces that are tilted at random, and has been falling for a step.
class RandomHeaps {
 public:
  static constexpr int kRow = 5, kLayer = kRow * kRow;

  explicit RandomHeaps(unsigned seed) : engine_(seed) {}

  Problem next(int layers) {
    Problem problem;
    for (int i = 0; i < layers * kLayer; ++i) {
      const int layer = i / kLayer, row = i / kRow % kRow, column = i % kRow;
      const double mass = real(0.01, 0.04);
      const Eigen::Vector3d com(kPitch * column, kPitch * row, kPitch * (layer + 0.5));
      problem.bodies.push_back({mass,
                                mass * 1e-4 * Eigen::Matrix3d::Identity(),
                                com,
                                {vector(0.05) - Eigen::Vector3d(0, 0, 0.1), vector(1)}});
      for (int k = 0; k < 4; ++k) {
        const int below_row = row + k / 2 - layer % 2, below_column = column + k % 2 - layer % 2;
        const bool is_there =
            below_row >= 0 && below_row < kRow && below_column >= 0 && below_column < kRow;
        if (layer > 0 && !is_there) continue;
        ContactDescription contact;
        contact.a = i;
        contact.b = layer == 0 ? ContactProblem::kFixed
                               : (layer - 1) * kLayer + below_row * kRow + below_column;
        const Eigen::Vector3d towards(k % 2 - 0.5, k / 2 - 0.5, -1);
        contact.p = com + 0.5 * kPitch * towards;
        contact.n = (Eigen::Vector3d(0, 0, 1) + vector(0.4)).normalized();
        contact.friction = real(0.1, 0.5);
        contact.compliance_m_s_ns = 1e-3;
        problem.contacts.push_back(contact);
      }
    }
    return problem;
  }

 private:
  static constexpr double kPitch = 0.04;  // [m]
  double real(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_()) / 4294967296.0;
  }
  Eigen::Vector3d vector(double most) {
    const double x = real(-most, most), y = real(-most, most), z = real(-most, most);
    return {x, y, z};
  }
  std::mt19937 engine_;
};

}  // namespace aprsim::physics
