// A scene in Jolt as it was built from source. usage: jolt_native MODEL; jolt_process.hpp says what
// it is asked and answers.

// First, as Jolt demands.
#include <Jolt/Jolt.h>
// Then its others.
#include <Jolt/ConfigurationString.h>
#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/ContactListener.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/CylinderShape.h>
#include <Jolt/Physics/Collision/Shape/OffsetCenterOfMassShape.h>
#include <Jolt/Physics/Collision/Shape/StaticCompoundShape.h>
#include <Jolt/Physics/Collision/Shape/TaperedCylinderShape.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>
#include <fstream>
#include <iostream>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "tests/benchmarks/support/clock.hpp"

namespace {

using Json = nlohmann::json;

constexpr unsigned kMostBodies = 1024, kMostPairs = 16384, kMostContacts = 16384;
constexpr unsigned kWorkMemory = 64U << 20U;
constexpr JPH::ObjectLayer kFixed = 0, kFree = 1;

class Layers : public JPH::BroadPhaseLayerInterface {
 public:
  [[nodiscard]] JPH::uint GetNumBroadPhaseLayers() const override { return 2; }
  [[nodiscard]] JPH::BroadPhaseLayer GetBroadPhaseLayer(JPH::ObjectLayer layer) const override {
    return JPH::BroadPhaseLayer(static_cast<JPH::uint8>(layer));
  }
  [[nodiscard]] const char* GetBroadPhaseLayerName(JPH::BroadPhaseLayer /*layer*/) const {
    return "layer";
  }
};
class LayerAgainstBroad : public JPH::ObjectVsBroadPhaseLayerFilter {
 public:
  [[nodiscard]] bool ShouldCollide(JPH::ObjectLayer a, JPH::BroadPhaseLayer b) const override {
    return a == kFree || b == JPH::BroadPhaseLayer(kFree);
  }
};
class LayerAgainstLayer : public JPH::ObjectLayerPairFilter {
 public:
  [[nodiscard]] bool ShouldCollide(JPH::ObjectLayer a, JPH::ObjectLayer b) const override {
    return a == kFree || b == kFree;
  }
};

/// Looks at contacts in the steps that are not timed.
class Looker : public JPH::ContactListener {
 public:
  void OnContactAdded(const JPH::Body& /*a*/, const JPH::Body& /*b*/,
                      const JPH::ContactManifold& manifold,
                      JPH::ContactSettings& /*settings*/) override {
    take(manifold);
  }
  void OnContactPersisted(const JPH::Body& /*a*/, const JPH::Body& /*b*/,
                          const JPH::ContactManifold& manifold,
                          JPH::ContactSettings& /*settings*/) override {
    take(manifold);
  }
  int contacts = 0;
  double deepest_m = 0;

 private:
  void take(const JPH::ContactManifold& manifold) {
    contacts += static_cast<int>(manifold.mRelativeContactPointsOn1.size());
    deepest_m = std::max(deepest_m, double(manifold.mPenetrationDepth));
  }
};

JPH::Vec3 vector(const Json& v) { return {v.at(0), v.at(1), v.at(2)}; }
JPH::RVec3 place(const Json& v) { return {v.at(0), v.at(1), v.at(2)}; }

JPH::ShapeRefC created(const JPH::ShapeSettings& settings) {
  const auto result = settings.Create();
  if (result.HasError()) throw std::runtime_error(result.GetError().c_str());
  return result.Get();
}

/// A cone or a cylinder about z; Jolt's are about y.
JPH::ShapeRefC round_shape(const Json& part, float margin) {
  const float half = part.at("half_height"), low = part.at("low_radius"),
              high = part.at("high_radius");
  if (low == high) return created(JPH::CylinderShapeSettings(half, low, margin));
  return created(JPH::TaperedCylinderShapeSettings(half, high, low, margin));
}

JPH::ShapeRefC shape(const Json& parts, float margin) {
  if (parts.size() == 1) {
    return created(JPH::BoxShapeSettings(vector(parts.front().at("half")), margin));
  }
  JPH::StaticCompoundShapeSettings compound;
  const JPH::Quat upright = JPH::Quat::sRotation(JPH::Vec3::sAxisX(), 0.5F * JPH::JPH_PI);
  for (const Json& part : parts) {
    if (part.contains("half")) {
      compound.AddShape(vector(part.at("at")), JPH::Quat::sIdentity(),
                        created(JPH::BoxShapeSettings(vector(part.at("half")), margin)));
    } else {
      compound.AddShape(vector(part.at("at")), upright, round_shape(part, margin));
    }
  }
  const JPH::ShapeRefC whole = created(compound);
  // The shapes' own density says another centre of mass than the scene.
  return created(JPH::OffsetCenterOfMassShapeSettings(-whole->GetCenterOfMass(), whole));
}

class Simulation {
 public:
  explicit Simulation(const Json& model) : step_s_(model.at("step_s")) {
    system_.Init(kMostBodies, 0, kMostPairs, kMostContacts, layers_, against_broad_,
                 against_layer_);
    system_.SetGravity(JPH::Vec3(0, 0, -model.at("gravity").get<float>()));
    JPH::PhysicsSettings settings = system_.GetPhysicsSettings();
    const Json& given = model.at("settings");
    settings.mNumVelocitySteps = given.at("mNumVelocitySteps");
    settings.mNumPositionSteps = given.at("mNumPositionSteps");
    settings.mSpeculativeContactDistance = given.at("mSpeculativeContactDistance");
    settings.mPenetrationSlop = given.at("mPenetrationSlop");
    settings.mManifoldTolerance = given.at("mManifoldTolerance");
    settings.mBodyPairCacheMaxDeltaPositionSq = given.at("mBodyPairCacheMaxDeltaPositionSq");
    settings.mBodyPairCacheCosMaxDeltaRotationDiv2 =
        given.at("mBodyPairCacheCosMaxDeltaRotationDiv2");
    settings.mContactPointPreserveLambdaMaxDistSq =
        given.at("mContactPointPreserveLambdaMaxDistSq");
    // Bodies on a belt would fall asleep.
    settings.mAllowSleeping = false;
    system_.SetPhysicsSettings(settings);
    for (const Json& body : model.at("bodies")) {
      add(body, model.at("friction").at(body.at("surface").get<std::string>()),
          model.at("convex_radius"));
    }
    system_.OptimizeBroadPhase();
  }

  /// Times of the steps but the last, and the contacts at that one.
  Json run(const std::vector<double>& speeds) {
    std::vector<double> us;
    for (std::size_t i = 0; i + 1 < speeds.size(); ++i) {
      const double start = aprsim::bench::thread_cpu_s();
      step(speeds[i]);
      us.push_back(1e6 * (aprsim::bench::thread_cpu_s() - start));
    }
    Looker looker;
    system_.SetContactListener(&looker);
    step(speeds.back());
    system_.SetContactListener(nullptr);
    return {{"us", us}, {"contacts", looker.contacts}, {"deepest_m", looker.deepest_m}};
  }
  [[nodiscard]] Json poses() const {
    Json out = Json::array();
    for (const JPH::BodyID& id : bodies_) {
      const auto& bodies = system_.GetBodyInterfaceNoLock();
      const JPH::RVec3 p = bodies.GetCenterOfMassPosition(id);
      const JPH::Quat q = bodies.GetRotation(id);
      out.push_back(
          Json::array({p.GetX(), p.GetY(), p.GetZ(), q.GetW(), q.GetX(), q.GetY(), q.GetZ()}));
    }
    return {{"poses", out}};
  }

 private:
  void step(double belt_speed) {
    if (!belt_.IsInvalid()) {
      system_.GetBodyInterfaceNoLock().SetLinearVelocity(
          belt_, JPH::Vec3(static_cast<float>(belt_speed), 0, 0));
    }
    const auto error = system_.Update(step_s_, 1, &memory_, &jobs_);
    if (error != JPH::EPhysicsUpdateError::None) throw std::runtime_error("Jolt: out of room");
  }
  void add(const Json& body, float friction, float margin) {
    const bool free = body.at("motion") == "free", belt = body.at("motion") == "belt";
    const Json& q = body.at("q");
    JPH::BodyCreationSettings settings(shape(body.at("shapes"), margin), place(body.at("p")),
                                       JPH::Quat(q.at(1), q.at(2), q.at(3), q.at(0)).Normalized(),
                                       free   ? JPH::EMotionType::Dynamic
                                       : belt ? JPH::EMotionType::Kinematic
                                              : JPH::EMotionType::Static,
                                       free ? kFree : kFixed);
    settings.mFriction = friction;
    settings.mRestitution = 0;
    settings.mLinearDamping = settings.mAngularDamping = 0;
    settings.mApplyGyroscopicForce = true;
    settings.mAllowSleeping = false;
    if (free) {
      settings.mOverrideMassProperties = JPH::EOverrideMassProperties::MassAndInertiaProvided;
      settings.mMassPropertiesOverride.mMass = body.at("mass");
      settings.mMassPropertiesOverride.mInertia = JPH::Mat44::sScale(vector(body.at("inertia")));
      // Also where the scene gives a body nothing to turn with about an axis.
      settings.mMassPropertiesOverride.mInertia(3, 3) = 1;
    }
    const JPH::BodyID id =
        system_.GetBodyInterfaceNoLock().CreateAndAddBody(settings, JPH::EActivation::Activate);
    if (belt) belt_ = id;
    bodies_.push_back(id);
  }

  float step_s_;
  Layers layers_;
  LayerAgainstBroad against_broad_;
  LayerAgainstLayer against_layer_;
  JPH::TempAllocatorImpl memory_{kWorkMemory};
  JPH::JobSystemSingleThreaded jobs_{JPH::cMaxPhysicsJobs};
  JPH::PhysicsSystem system_;
  std::vector<JPH::BodyID> bodies_;
  JPH::BodyID belt_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: jolt_native MODEL\n";
    return 2;
  }
  JPH::RegisterDefaultAllocator();
  JPH::Factory::sInstance = new JPH::Factory;
  JPH::RegisterTypes();
  try {
    Simulation simulation(Json::parse(std::ifstream(argv[1])));
    const std::string version =
        std::to_string(JPH_VERSION_MAJOR) + "." + std::to_string(JPH_VERSION_MINOR) + "." +
        std::to_string(JPH_VERSION_PATCH) + ", " + JPH::GetConfigurationString();
    std::cout << Json{{"version", version}} << std::endl;
    for (std::string line; std::getline(std::cin, line);) {
      const auto speeds = Json::parse(line).get<std::vector<double>>();
      std::cout << (speeds.empty() ? simulation.poses() : simulation.run(speeds)) << std::endl;
    }
  } catch (const std::exception& error) {
    std::cerr << "jolt_native: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
