#include "world/physics/contacts/contact_cache.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/cell_builder.hpp"
#include "world/physics/collision/pairs/narrow_phase.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kTray = 0, kGear = 1;

/// A gear in a pocket of a tray, anywhere.
class Seated {
 public:
  explicit Seated(unsigned seed) : random_(seed) {
    auto scene = empty_scene();
    add_tray(scene, "tray", "small4", {0, 0}, {"s1=gear"});
    scene_ = std::move(scene);
    bodies_ = make_free_bodies(scene_, {});
    X_TG_ = tray().X_WB.inverse() * gear().X_WB;
    // As deep as what rests, off the middle and tilted as far as the pocket lets it.
    X_TG_ = motion(2e-4, 1e-3) * X_TG_;
    X_TG_.translation().z() -= 2e-5;
    place(motion(1, 3));
  }

  [[nodiscard]] const FreeBody& tray() const { return bodies_[kTray]; }
  [[nodiscard]] const FreeBody& gear() const { return bodies_[kGear]; }
  [[nodiscard]] ContactCache::Pair pair() const { return {kGear, kTray, &gear(), &tray()}; }
  [[nodiscard]] std::vector<Contact> found() const {
    std::vector<Contact> out;
    gear_tray(gear().gear_shape, gear().X_WB, *tray().tray, tray().X_WB, kGear, kTray, out);
    return out;
  }
  /// Both elsewhere, the gear moved in the tray by so much at its farthest point.
  void move_on(double moved_m) {
    const Vector3d com = gear().mass.com;
    const double share = std::uniform_real_distribution<double>(0, 1)(random_);
    const Vector3d turn = share * moved_m / gear().radius_m * direction();
    Isometry3d D = Isometry3d::Identity();
    D.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).matrix();
    const Vector3d middle = X_TG_ * com;
    D.translation() = middle + (1 - share) * moved_m * direction() - D.linear() * middle;
    X_TG_ = D * X_TG_;
    place(motion(1, 3));
  }

 private:
  Vector3d direction() {
    std::normal_distribution<double> normal;
    const double x = normal(random_), y = normal(random_), z = normal(random_);
    return Vector3d(x, y, z).normalized();
  }
  Isometry3d motion(double displacement_m, double angle) {
    Isometry3d out = Isometry3d::Identity();
    out.linear() = Eigen::AngleAxisd(angle, direction()).matrix();
    out.translation() = displacement_m * direction();
    return out;
  }
  void place(const Isometry3d& X_WT) {
    bodies_[kTray].place(X_WT, Vector3d::Zero(), Vector3d::Zero());
    bodies_[kGear].place(X_WT * X_TG_, Vector3d::Zero(), Vector3d::Zero());
  }

  std::mt19937_64 random_;
  scene::Scene scene_;
  std::vector<FreeBody> bodies_;
  Isometry3d X_TG_;
};

double deepest(const std::vector<Contact>& contacts) {
  double depth = -1;
  for (const Contact& contact : contacts) depth = std::max(depth, contact.depth_m);
  return depth;
}

std::vector<Contact> known(ContactCache& kept, const ContactCache::Pair& pair) {
  std::vector<Contact> out;
  EXPECT_TRUE(kept.append(pair, out));
  return out;
}

// A gear that hardly moves has the contacts that would be found, wherever its tray has gone to.
TEST(ContactCache, AreThoseThatWouldBeFound) {
  int contacts = 0, same = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    Seated seated(seed);
    ContactCache kept(2);
    const auto before = seated.found();
    kept.store(seated.pair(), before, 0);
    kept.begin_step();
    seated.move_on(0.9 * ContactCache::kReuseDistance);
    const auto now = seated.found(), carried = known(kept, seated.pair());
    ASSERT_EQ(carried.size(), before.size());
    EXPECT_NEAR(deepest(carried), deepest(now), ContactCache::kReuseDistance);
    for (const Contact& contact : carried) {
      ++contacts;
      EXPECT_EQ(contact.a, kGear);
      EXPECT_EQ(contact.b, kTray);
      EXPECT_EQ(contact.pair, SurfacePair::kGearTray);
      same += std::ranges::any_of(now, [&](const Contact& other) {
        return (other.p_W - contact.p_W).norm() < 1e-4 && (other.n_W - contact.n_W).norm() < 1e-2 &&
               std::abs(other.depth_m - contact.depth_m) < 0.5 * ContactCache::kReuseDistance;
      });
    }
  }
  EXPECT_GT(contacts, 600);
  EXPECT_GT(same, 0.9 * contacts);
}

TEST(ContactCache, AreFoundAnewWhenTheBodyHasMoved) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    Seated seated(seed);
    ContactCache kept(2);
    kept.store(seated.pair(), seated.found(), 0);
    std::vector<Contact> out;
    // Little by little counts from where they were found.
    int steps = 0;
    for (bool carried = true; carried && steps < 200; ++steps) {
      kept.begin_step();
      seated.move_on(0.5 * ContactCache::kReuseDistance);
      carried = kept.append(seated.pair(), out);
    }
    EXPECT_GE(steps, 2);
    EXPECT_LT(steps, 200);
    seated.move_on(2.1 * ContactCache::kReuseDistance);
    kept.store(seated.pair(), seated.found(), 0);
    seated.move_on(2.1 * ContactCache::kReuseDistance);
    EXPECT_FALSE(kept.append(seated.pair(), out));
  }
}

TEST(ContactCache, AreForgottenUnlessTheyAreUsedInEachStep) {
  const Seated seated(3);
  ContactCache kept(2);
  kept.store(seated.pair(), seated.found(), 0);
  std::vector<Contact> out;
  for (int step = 0; step < 5; ++step) {
    kept.begin_step();
    EXPECT_TRUE(kept.append(seated.pair(), out)) << step;
  }
  kept.begin_step();
  kept.begin_step();
  EXPECT_FALSE(kept.append(seated.pair(), out));
  EXPECT_TRUE(kept.save().empty());
  const ContactCache::Pair other{kGear, -1, &seated.gear()};
  EXPECT_FALSE(kept.append(other, out));
}

TEST(ContactCache, GoOnFromASavedStateBitForBit) {
  Seated seated(5);
  ContactCache kept(2);
  kept.store(seated.pair(), seated.found(), 0);
  ContactCache restored(2);
  restored.restore(kept.save());
  for (auto* one : {&kept, &restored}) one->begin_step();
  seated.move_on(0.5 * ContactCache::kReuseDistance);
  const auto a = known(kept, seated.pair()), b = known(restored, seated.pair());
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].p_W, b[i].p_W);
    EXPECT_EQ(a[i].n_W, b[i].n_W);
    EXPECT_EQ(a[i].depth_m, b[i].depth_m);
  }
  // The cache of a world with fewer bodies.
  ContactCache other(kGear);
  other.restore(kept.save());
  EXPECT_TRUE(other.save().empty());
}

}  // namespace
}  // namespace aprsim::physics::test
