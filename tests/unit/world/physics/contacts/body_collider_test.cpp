#include "world/physics/contacts/body_collider.hpp"

#include <algorithm>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Two trays, then two gears, at any attitude.
class Bodies {
 public:
  explicit Bodies(unsigned seed) : random_(seed), scene_(scene()), model_(scene_, {}, {}) {}

  [[nodiscard]] FreeBody& body(int i) { return model_.body(i); }
  [[nodiscard]] std::vector<Contact> find(int a, int b) {
    std::vector<Contact> out;
    BodyCollider collider(model_);
    collider.free_on_free(a, b, out);
    return out;
  }
  /// Puts one on the other from any side, some 30 um deep; false where that does not succeed.
  bool press(int a, int b) {
    body(b).place(anywhere(), Vector3d::Zero(), Vector3d::Zero());
    Isometry3d X_WA = anywhere();
    const Vector3d from = direction();
    double inside = 0, outside = 0.4;
    for (int i = 0; i < 12; ++i) {
      const double middle = 0.5 * (inside + outside);
      X_WA.translation() = body(b).com_W() + middle * from;
      body(a).place(X_WA, Vector3d::Zero(), Vector3d::Zero());
      (find(a, b).empty() ? outside : inside) = middle;
    }
    X_WA.translation() = body(b).com_W() + inside * from;
    body(a).place(X_WA, Vector3d::Zero(), Vector3d::Zero());
    return !find(a, b).empty();
  }
  void move(int a, const Vector3d& v_W) { body(a).place(body(a).X_WB, v_W, Vector3d::Zero()); }

 private:
  static scene::Scene scene() {
    auto out = empty_scene();
    for (const char* name : {"tray a", "tray b"}) add_tray(out, name, "small4", {0, 0}, {});
    for (const char* name : {"gear a", "gear b"}) add_gear(out, name, "small", {});
    return out;
  }
  Vector3d direction() {
    std::normal_distribution<double> normal;
    const double x = normal(random_), y = normal(random_), z = normal(random_);
    return Vector3d(x, y, z).normalized();
  }
  Isometry3d anywhere() {
    const double angle = std::uniform_real_distribution<double>(0, std::numbers::pi)(random_);
    return Isometry3d(Eigen::AngleAxisd(angle, direction()));
  }

  std::mt19937_64 random_;
  scene::Scene scene_;
  PhysicsModel model_;
};

class ColliderOf : public testing::TestWithParam<std::pair<int, int>> {};

// Bodies that separate as fast as penetration is corrected keep their contact, whichever lies on
// which, and however far their middles are from the contact.
TEST_P(ColliderOf, SeparatedBodiesKeepTheirContact) {
  constexpr double kCorrected = 0.2, kStep = 1e-3;  // of the depth in a step; [s]
  const auto [a, b] = GetParam();
  int checked = 0, lost = 0;
  for (unsigned seed = 0; seed < 1500; ++seed) {
    Bodies bodies(seed);
    if (!bodies.press(a, b)) continue;
    const auto before = bodies.find(a, b);
    const Contact& deepest = *std::ranges::max_element(before, {}, &Contact::depth_m);
    if (deepest.depth_m < 1e-5 || deepest.depth_m > 1e-4) continue;
    ++checked;
    bodies.move(a, kCorrected * deepest.depth_m / kStep * deepest.n_W);
    lost += bodies.find(a, b).empty();
  }
  EXPECT_GT(checked, 300);
  EXPECT_EQ(lost, 0) << "of " << checked;
}

INSTANTIATE_TEST_SUITE_P(Pairs, ColliderOf,
                         testing::Values(std::pair(1, 0), std::pair(2, 0), std::pair(3, 2)));

}  // namespace
}  // namespace aprsim::physics::test
