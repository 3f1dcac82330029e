#include "world/physics/collision/pairs/circle_maxima.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "world/physics/collision/pairs/frustum_contact.hpp"

namespace aprsim::physics::detail {
namespace {

/// Frusta, and circles that go through them or by.
class RandomCircles {
 public:
  RandomCircles() {
    piece.high_exposed = piece.low_exposed = true;
    piece.z0 = -real(0.002, 0.02);
    piece.z1 = real(0.002, 0.02);
    piece.r0 = real(0.003, 0.03);
    piece.r1 = whole(0, 1) == 0 ? piece.r0 : real(0.003, 0.03);
    piece.slope = (piece.r1 - piece.r0) / (piece.z1 - piece.z0);
    piece.cosine = 1 / std::sqrt(1 + piece.slope * piece.slope);
    // Some are glued to others.
    piece.z_out_low = whole(0, 2) == 0 ? -1e30 : piece.z0;
    piece.z_out_high = whole(0, 2) == 0 ? 1e30 : piece.z1;
  }
  void next() {
    radius = real(0.002, 0.04);
    const Eigen::Vector3d u = direction();
    const Eigen::Vector3d a1 = u.unitOrthogonal();
    circle.a1 = radius * a1;
    circle.a2 = radius * u.cross(a1);
    circle.c = real(0, 0.04) * direction();
  }
  static int whole(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(engine); }

  Piece piece;
  CircleBasis circle;
  double radius = 0;

 private:
  static double real(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(engine);
  }
  static Eigen::Vector3d direction() {
    std::normal_distribution<double> normal;
    const double x = normal(engine), y = normal(engine), z = normal(engine);
    return Eigen::Vector3d(x, y, z).normalized();
  }
  static inline std::mt19937_64 engine{11};
};

/// Depth at an angle from sample 0.
double depth_at(const RandomCircles& of, double angle) {
  const Eigen::Vector3d p =
      of.circle.c + std::cos(angle) * of.circle.a1 + std::sin(angle) * of.circle.a2;
  return penetration_exit(of.piece, std::hypot(p.x(), p.y()), p.z()).depth;
}

/// The deepest point is found wherever the circle lies, but for those that hide between samples.
TEST(CircleMaxima, FindsTheDeepestPoint) {
  constexpr int kPieces = 60, kCircles = 60, kFine = 20000;
  int touching = 0, missed = 0;
  double farthest_m = 0;
  for (int n = 0; n < kPieces * kCircles; ++n) {
    static RandomCircles at;
    if (n % kCircles == 0) at = RandomCircles();
    at.next();
    double deepest = 0;
    for (int k = 0; k < kFine; ++k) {
      deepest = std::max(deepest, depth_at(at, 2 * std::numbers::pi * k / kFine));
    }
    ClosedCircleSamples samples;
    for (std::size_t i = 0; i < kCircleSamples; ++i) {
      samples[i] = depth_at(at, kSampleAngle * static_cast<double>(i));
    }
    samples.back() = samples.front();
    CircleSamples any;  // nothing is known of what is between them
    any.fill(1);
    double found = 0;
    const auto exit_at = [&](const CirclePoint& point) {
      return penetration_exit_along(at.piece, point);
    };
    circle_extrema(
        find_candidate_samples(samples, any, at.radius), at.circle, at.radius, exit_at,
        [&](const CircleMaximum& maximum) { found = std::max(found, maximum.exit.depth); });
    if (deepest <= 0) continue;
    ++touching;
    if (found < deepest - 1e-8) {
      ++missed;
      farthest_m = std::max(farthest_m, deepest - found);
    }
    EXPECT_LE(found, deepest + 2 * std::numbers::pi / kFine * at.radius);
  }
  std::printf("%d touching, %d missed, by %.2g m at most\n", touching, missed, farthest_m);
  EXPECT_GT(touching, 1000);
  EXPECT_LT(missed, touching / 100);
}

/// Slopes are those of the depth, on every surface.
TEST(CircleMaxima, SlopesAreDerivatives) {
  constexpr double kStep = 1e-6;
  int compared = 0;
  for (int n = 0; n < 4000; ++n) {
    RandomCircles at;
    at.next();
    const Arc arc = at.circle.from_sample(RandomCircles::whole(0, kCircleSamples - 1));
    const double step = kSampleStep * RandomCircles::whole(-8, 8) / 8;
    const ExitWithGradient here = penetration_exit_along(at.piece, arc.at(step));
    const ExitWithGradient before = penetration_exit_along(at.piece, arc.at(step - kStep));
    const ExitWithGradient after = penetration_exit_along(at.piece, arc.at(step + kStep));
    if (before.kind != here.kind || after.kind != here.kind) continue;
    ++compared;
    EXPECT_NEAR(here.slope, (after.depth - before.depth) / (2 * kStep), 1e-6 * (1 + at.radius));
    EXPECT_EQ(here.turn > 0, here.slope > 0);
  }
  EXPECT_GT(compared, 3000);
}

}  // namespace
}  // namespace aprsim::physics::detail
