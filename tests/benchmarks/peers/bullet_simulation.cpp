// The trays of Table 1 in Bullet.

#include <btBulletDynamicsCommon.h>
#include <vector>

#include <Eigen/Eigenvalues>

#include "tests/benchmarks/peers/peer_engine.hpp"
#include "tests/benchmarks/peers/peer_geometry.hpp"
#include "world/physics/bodies/mass_properties.hpp"

namespace aprsim::bench {
namespace {

struct BulletSettings {
  const char* name;
  int iterations = 10;
  double scale = 1;  ///< units per metre: its manual advises against objects under 0.2 units
  double margin_m = 4e-2;
};

constexpr BulletSettings kBulletSettings[] = {
    {"default, 10 iterations", 10, 1, 4e-2},
    {"margin 0.1 mm, 10 iterations", 10, 1, 1e-4},
    {"margin 0.1 mm, 50 iterations", 50, 1, 1e-4},
    {"scaled by 20, margin 0.1 mm, 10 iterations", 10, 20, 1e-4},
    {"scaled by 20, margin 0.1 mm, 50 iterations", 50, 20, 1e-4}};

btVector3 bullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}
btQuaternion bullet(const Eigen::Quaterniond& q) {
  return {static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()), static_cast<btScalar>(q.z()),
          static_cast<btScalar>(q.w())};
}

class BulletSimulation : public TraySimulation {
 public:
  BulletSimulation(const scene::Scene& scene, const BulletSettings& settings)
      : step_s_(scene.physics.step_s), scale_(settings.scale), margin_m_(settings.margin_m) {
    world_.setGravity(bullet(Eigen::Vector3d(0, 0, -scene.physics.gravity_m_s2 * scale_)));
    world_.getSolverInfo().m_numIterations = settings.iterations;
    add_belt(scene);
    const double gear_mu = scene.physics.friction.gear_tray;
    for (const auto& tray : scene.trays) {
      const auto& type = scene.tray_types.at(tray.type);
      auto& compound = new_compound();
      const auto mass = physics::tray_mass(type);
      for (const auto& box : tray_boxes(type)) {
        add_part(compound, keep(new btBoxShape(length(box.half))), box.centre - mass.com);
      }
      // Bullet multiplies the coefficients of a pair.
      add_body(compound, mass, tray.X_WP, gear_mu);
    }
    for (const auto& gear : scene.gears) {
      const auto& type = scene.gear_types.at(gear.type);
      auto& compound = new_compound();
      const auto mass = physics::gear_mass(type);
      for (const auto& part : gear_cylinders(type)) {
        const Eigen::Vector3d half(part.radius, part.radius, part.half_height);
        add_part(compound, keep(new btCylinderShapeZ(length(half))),
                 Eigen::Vector3d(0, 0, part.z_centre) - mass.com);
      }
      add_body(compound, mass, gear.X_WP, 1);
    }
    belt_->setFriction(static_cast<btScalar>(scene.physics.friction.tray_belt / gear_mu));
  }
  ~BulletSimulation() override {
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }

  void step(double belt_speed_m_s) override {
    travel_m_ += belt_speed_m_s * step_s_;
    btTransform to = belt_start_;
    to.getOrigin().setX(belt_start_.getOrigin().x() + static_cast<btScalar>(travel_m_ * scale_));
    belt_->getMotionState()->setWorldTransform(to);
    world_.stepSimulation(static_cast<btScalar>(step_s_), 0);
  }
  [[nodiscard]] Pose body(int index) const override {
    const auto& entry = parts_[static_cast<std::size_t>(index)];
    const btTransform& X = entry.body->getWorldTransform();
    const btQuaternion q = X.getRotation();
    const Eigen::Quaterniond turn(q.w(), q.x(), q.y(), q.z());
    const Eigen::Vector3d com(X.getOrigin().x(), X.getOrigin().y(), X.getOrigin().z());
    return {com / scale_ - turn.normalized() * entry.com, turn.normalized()};
  }
  [[nodiscard]] int contact_count() const override {
    int count = 0;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      count += dispatcher_.getManifoldByIndexInternal(i)->getNumContacts();
    }
    return count;
  }

 private:
  struct Part {
    btRigidBody* body = nullptr;
    Eigen::Vector3d com;
  };

  [[nodiscard]] btVector3 length(const Eigen::Vector3d& metres) const {
    return bullet(metres * scale_);
  }
  btCollisionShape* keep(btCollisionShape* shape) {
    shape->setMargin(static_cast<btScalar>(margin_m_ * scale_));
    shapes_.emplace_back(shape);
    return shape;
  }
  btCompoundShape& new_compound() {
    auto* compound = new btCompoundShape;
    shapes_.emplace_back(compound);
    return *compound;
  }
  void add_part(btCompoundShape& compound, btCollisionShape* shape, const Eigen::Vector3d& at) {
    compound.addChildShape(btTransform(btQuaternion::getIdentity(), length(at)), shape);
  }
  btRigidBody* add_rigid(btScalar mass, btCollisionShape* shape, const btTransform& at,
                         const btVector3& inertia) {
    states_.push_back(std::make_unique<btDefaultMotionState>(at));
    btRigidBody::btRigidBodyConstructionInfo info(mass, states_.back().get(), shape, inertia);
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    // A body on a belt moves slower than the sleeping threshold: it must not sleep.
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(bodies_.back().get());
    return bodies_.back().get();
  }
  void add_body(btCompoundShape& compound, const physics::MassProperties& mass, const Pose& pose,
                double mu) {
    const btTransform at(bullet(pose.q), length(pose.p + pose.q * mass.com));
    const Eigen::Vector3d inertia = mass.inertia.diagonal() * scale_ * scale_;
    auto* body = add_rigid(static_cast<btScalar>(mass.mass_kg), &compound, at, bullet(inertia));
    body->setFriction(static_cast<btScalar>(mu));
    parts_.push_back({body, mass.com});
  }
  void add_belt(const scene::Scene& scene) {
    const auto& belt = *scene.conveyor;
    const Eigen::Vector3d half(3 * belt.length_m, belt.width_m, 0.05);
    belt_start_ = btTransform(btQuaternion::getIdentity(),
                              length(belt.X_WC.p - Eigen::Vector3d(0, 0, half.z())));
    belt_ = add_rigid(0, keep(new btBoxShape(length(half))), belt_start_, btVector3(0, 0, 0));
    belt_->setCollisionFlags(belt_->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  }

  double step_s_, scale_, margin_m_, travel_m_ = 0;
  btDefaultCollisionConfiguration configuration_;
  mutable btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btMotionState>> states_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  btRigidBody* belt_ = nullptr;
  btTransform belt_start_;
  std::vector<Part> parts_;
};

std::string bullet_version() {
  const int version = btGetVersion();
  return std::to_string(version / 100) + "." + std::to_string(version % 100) +
         (sizeof(btScalar) == 8 ? ", double" : ", float");
}

}  // namespace

PeerEngine bullet_engine() {
  PeerEngine engine{
      .name = "Bullet", .short_name = "bullet", .version = bullet_version(), .settings = {}};
  for (const auto& settings : kBulletSettings) {
    engine.settings.push_back({settings.name, [settings](const scene::Scene& scene) {
                                 return std::make_unique<BulletSimulation>(scene, settings);
                               }});
  }
  return engine;
}

}  // namespace aprsim::bench
