#include "tests/benchmarks/peers/ode_simulation.hpp"

#include <algorithm>
#include <vector>

#include "tests/benchmarks/peers/ode_handles.hpp"
#include "tests/benchmarks/peers/peer_engine.hpp"
#include "world/physics/bodies/mass_properties.hpp"
#include "world/physics/collision/pairs/narrow_phase.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using physics::SurfacePair;

// As ODE's manual advises; a slop, so that contacts persist.
constexpr double kErp = 0.2, kCfm = 1e-6, kSlop = 1e-5, kMostCorrecting = 0.5;
constexpr double kBeltDepth = 0.1;  // [m]

/// Something that never moves.
struct Fixed {
  Vector3d size;
  Isometry3d X_WS;
  bool belt = false;
};

/// A tray or a gear.
struct Free {
  ode::Body body;
  const scene::TrayType* tray = nullptr;
  physics::detail::GearShape gear;  // of a gear
  physics::MassProperties mass;
  double reach_m = 0;  ///< from its centre of mass
  Isometry3d X_WB;
  Vector3d com_W;
};

Vector3d slab_size(const scene::TrayType& type) {
  const Eigen::Vector2d xy = type.max_xy - type.min_xy;
  return {xy.x(), xy.y(), type.thickness_m};
}

Isometry3d slab_pose(const scene::TrayType& type, const Isometry3d& X_WP) {
  const Eigen::Vector2d xy = 0.5 * (type.min_xy + type.max_xy);
  return X_WP * Eigen::Translation3d(xy.x(), xy.y(), -0.5 * type.thickness_m);
}

class Quickstep : public OdeSimulation {
 public:
  Quickstep(const scene::Scene& scene, int iterations) : scene_(scene) {
    dInitODE2(0);
    world_.reset(dWorldCreate());
    joints_.reset(dJointGroupCreate(0));
    dWorldSetGravity(world_.get(), 0, 0, -scene.physics.gravity_m_s2);
    dWorldSetAutoDisableFlag(world_.get(), 0);
    dWorldSetQuickStepNumIterations(world_.get(), iterations);
    dWorldSetContactSurfaceLayer(world_.get(), kSlop);
    dWorldSetContactMaxCorrectingVel(world_.get(), kMostCorrecting);
    for (const auto& box : scene.fixed) fixed_.push_back({box.size, box.X_WS.isometry()});
    if (scene.conveyor) {
      const auto& belt = *scene.conveyor;
      fixed_.push_back({{belt.length_m, belt.width_m, kBeltDepth},
                        belt.X_WC.isometry() * Eigen::Translation3d(0, 0, -0.5 * kBeltDepth),
                        true});
    }
    for (const auto& tray : scene.trays) {
      const auto& type = scene.tray_types.at(tray.type);
      const double reach = slab_size(type).norm();
      add({.tray = &type, .mass = physics::tray_mass(type), .reach_m = 0.6 * reach}, tray.X_WP);
    }
    for (const auto& gear : scene.gears) {
      const auto& type = scene.gear_types.at(gear.type);
      const double height = std::max(type.peg_top_m, type.hub_height_m);
      add({.gear = type,
           .mass = physics::gear_mass(type),
           .reach_m = std::hypot(std::max(type.disc_radius_m, type.hub_top_radius_m), height)},
          gear.X_WP);
    }
  }

  void step(double belt_speed_m_s) override {
    for (Free& free : bodies_) read(free);
    found_.clear();
    find_contacts();
    dJointGroupEmpty(joints_.get());
    deepest_m_ = 0;
    for (const auto& [contact, belt] : found_) add_joint(contact, belt, belt_speed_m_s);
    dWorldQuickStep(world_.get(), scene_.physics.step_s);
  }
  [[nodiscard]] Pose body(int index) const override {
    const Free& free = bodies_[static_cast<std::size_t>(index)];
    const Eigen::Matrix3d R = ode::matrix(dBodyGetRotation(free.body.get()));
    const Vector3d com = ode::vector(dBodyGetPosition(free.body.get()));
    return {com - R * free.mass.com, Eigen::Quaterniond(R)};
  }
  [[nodiscard]] int contact_count() const override { return static_cast<int>(found_.size()); }
  [[nodiscard]] double deepest_m() const override { return deepest_m_; }

 private:
  struct Found {
    physics::Contact contact;
    bool belt = false;
  };

  void add(Free free, const Pose& X_WB) {
    free.body.reset(dBodyCreate(world_.get()));
    const auto& I = free.mass.inertia;
    dMass mass;
    dMassSetParameters(&mass, free.mass.mass_kg, 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1),
                       I(0, 2), I(1, 2));
    dBodySetMass(free.body.get(), &mass);
    ode::set_rotation(free.body.get(), X_WB.q.toRotationMatrix());
    ode::set_position(free.body.get(), X_WB.isometry() * free.mass.com);
    read(free);
    bodies_.push_back(std::move(free));
  }
  static void read(Free& free) {
    free.X_WB.setIdentity();
    free.X_WB.linear() = ode::matrix(dBodyGetRotation(free.body.get()));
    free.com_W = ode::vector(dBodyGetPosition(free.body.get()));
    free.X_WB.translation() = free.com_W - free.X_WB.linear() * free.mass.com;
  }

  /// Sweep and prune along x over spheres.
  void find_contacts() {
    order_.clear();
    for (int i = 0; i < static_cast<int>(bodies_.size()); ++i) order_.push_back(i);
    const auto low = [this](int i) { return at(i).com_W.x() - at(i).reach_m; };
    std::sort(order_.begin(), order_.end(), [&](int a, int b) { return low(a) < low(b); });
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const Free& body = at(order_[i]);
      for (std::size_t k = i + 1; k < order_.size(); ++k) {
        if (low(order_[k]) > body.com_W.x() + body.reach_m) break;
        const Free& other = at(order_[k]);
        const double reach = body.reach_m + other.reach_m;
        if ((body.com_W - other.com_W).squaredNorm() > reach * reach) continue;
        const auto [lower, upper] = std::minmax(order_[i], order_[k]);  // gears come after trays
        touch(upper, lower);
      }
      for (const Fixed& fixed : fixed_) touch(order_[i], fixed);
    }
  }
  void touch(int upper, int lower) {
    const Free &a = at(upper), &b = at(lower);
    if (a.tray) {
      physics::box_box(slab_size(*a.tray), slab_pose(*a.tray, a.X_WB), slab_size(*b.tray),
                       slab_pose(*b.tray, b.X_WB), upper, lower, SurfacePair::kTrayTray, points_);
    } else if (b.tray) {
      physics::gear_tray(a.gear, a.X_WB, *b.tray, b.X_WB, upper, lower, points_);
    } else {
      physics::gear_gear(a.gear, a.X_WB, b.gear, b.X_WB, upper, lower, points_);
    }
    take_points(false);
  }
  void touch(int index, const Fixed& fixed) {
    const Free& a = at(index);
    const Vector3d from = fixed.X_WS.inverse() * a.com_W;
    if (((from.cwiseAbs() - 0.5 * fixed.size).array() > a.reach_m).any()) return;
    if (a.tray) {
      physics::box_box(slab_size(*a.tray), slab_pose(*a.tray, a.X_WB), fixed.size, fixed.X_WS,
                       index, physics::kGround,
                       fixed.belt ? SurfacePair::kTrayBelt : SurfacePair::kTrayGround, points_);
    } else {
      physics::gear_box(a.gear, a.X_WB, fixed.size, fixed.X_WS, index, physics::kGround,
                        SurfacePair::kGearGround, points_);
    }
    take_points(fixed.belt);
  }
  void take_points(bool belt) {
    for (const auto& point : points_) found_.push_back({point, belt});
    points_.clear();
  }

  [[nodiscard]] double friction(SurfacePair pair) const {
    const auto& mu = scene_.physics.friction;
    switch (pair) {
      case SurfacePair::kGearTray:
        return mu.gear_tray;
      case SurfacePair::kGearGear:
        return mu.gear_gear;
      case SurfacePair::kTrayBelt:
        return mu.tray_belt;
      case SurfacePair::kTrayGround:
        return mu.tray_ground;
      case SurfacePair::kTrayTray:
        return mu.tray_tray;
      default:
        return mu.gear_ground;
    }
  }
  void add_joint(const physics::Contact& contact, bool belt, double belt_speed_m_s) {
    dContact joint{};
    joint.surface.mode = dContactApprox1 | dContactSoftERP | dContactSoftCFM;
    joint.surface.mu = friction(contact.pair);
    joint.surface.soft_erp = kErp;
    joint.surface.soft_cfm = kCfm;
    ode::copy(contact.p_W, joint.geom.pos);
    ode::copy(contact.n_W, joint.geom.normal);
    joint.geom.depth = contact.depth_m;
    if (belt) {
      joint.surface.mode |= dContactFDir1 | dContactMotion1;
      joint.surface.motion1 = belt_speed_m_s;
      const Vector3d axis = fixed_.back().X_WS.linear().col(0);
      ode::copy((axis - axis.dot(contact.n_W) * contact.n_W).normalized(), joint.fdir1);
    }
    dBodyID other = contact.b < 0 ? nullptr : at(contact.b).body.get();
    dJointAttach(dJointCreateContact(world_.get(), joints_.get(), &joint), at(contact.a).body.get(),
                 other);
    deepest_m_ = std::max(deepest_m_, contact.depth_m);
  }

  [[nodiscard]] const Free& at(int index) const { return bodies_[static_cast<std::size_t>(index)]; }

  const scene::Scene& scene_;
  ode::World world_;
  ode::JointGroup joints_;
  std::vector<Fixed> fixed_;
  std::vector<Free> bodies_;
  std::vector<int> order_;
  std::vector<physics::Contact> points_;  // of one pair
  std::vector<Found> found_;
  double deepest_m_ = 0;
};

}  // namespace

std::unique_ptr<OdeSimulation> ode_simulation(const scene::Scene& scene, int iterations) {
  return std::make_unique<Quickstep>(scene, iterations);
}

PeerEngine ode_engine() {
  PeerEngine engine{
      .name = "ODE", .short_name = "ode", .version = APRSIM_ODE_VERSION, .settings = {}};
  for (const int iterations : {20, 50}) {
    engine.settings.push_back(
        {"quick step, " + std::to_string(iterations) + " iterations",
         [iterations](const scene::Scene& scene) { return ode_simulation(scene, iterations); }});
  }
  return engine;
}

}  // namespace aprsim::bench
