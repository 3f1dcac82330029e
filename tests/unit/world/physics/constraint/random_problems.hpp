#pragma once

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/constraint/contact_solver.hpp"

namespace aprsim::physics {

/// A problem together with its solver.
struct SolverBench : ContactProblem {
  ContactSolver solver;

  ContactSolver::Outcome solve(const ContactSolverParameters& parameters = {}) {
    return solver.solve(*this, parameters);
  }
};

/// However many Newton steps it takes.
inline constexpr ContactSolverParameters kStrict{.max_tolerance_m_s = 1e-8};

/// Bodies and contacts before they are added to a bench.
struct Problem {
  struct Body {
    double mass_kg;
    Eigen::Matrix3d inertia;
    Eigen::Vector3d com;
    Twist free;
  };
  std::vector<Body> bodies;
  std::vector<ContactDescription> contacts;

  void state_to(SolverBench& bench) const {
    bench.clear();
    for (const Body& b : bodies) bench.add_body(b.mass_kg, b.inertia, b.com, b.free, b.free);
    for (const ContactDescription& contact : contacts) bench.add_contact(contact);
  }
  ContactSolver::Outcome solve(SolverBench& bench) const {
    state_to(bench);
    return bench.solve(kStrict);
  }
};

/// A pile of boxes' worth of mass in space: each body touches the ground or some before it.
class RandomProblems {
 public:
  explicit RandomProblems(unsigned seed) : engine_(seed) {}

  Problem next() {
    Problem problem;
    const int count = whole(1, 12);
    for (int i = 0; i < count; ++i) {
      const double mass = std::pow(10, real(-2, 1));
      const double size = 0.1 * std::cbrt(mass);
      const Eigen::Matrix3d R = turn();
      const Eigen::Vector3d inertia =
          mass * size * size * Eigen::Vector3d(real(0.1, 1), real(0.5, 1), real(0.5, 1));
      problem.bodies.push_back({mass,
                                R * inertia.asDiagonal() * R.transpose(),
                                vector(0.3),
                                {vector(0.5) - Eigen::Vector3d(0, 0, 0.2), vector(3)}});
      for (int k = whole(1, 6); k > 0; --k) {
        const int other = whole(-1, i - 1);
        ContactDescription contact;
        contact.a = i;
        contact.b = other < 0 ? ContactProblem::kFixed : other;
        contact.p = problem.bodies.back().com + vector(size);
        contact.n = (Eigen::Vector3d(0, 0, 1) + vector(0.4)).normalized();
        contact.friction = whole(0, 4) == 0 ? 0 : real(0.05, 0.6);
        contact.compliance_m_s_ns = whole(0, 1) * 1e-3;
        problem.contacts.push_back(contact);
      }
    }
    return problem;
  }
  Eigen::Matrix3d turn() {
    return Eigen::AngleAxisd(real(0, 3), (vector(1) + 1e-3 * Eigen::Vector3d::UnitX()).normalized())
        .toRotationMatrix();
  }
  Eigen::Vector3d vector(double most) {
    return {real(-most, most), real(-most, most), real(-most, most)};
  }

 private:
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  double real(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  std::mt19937 engine_;
};

}  // namespace aprsim::physics
