// The trays of Table 1 in MuJoCo.

#include <cstddef>
#include <mujoco/mujoco.h>
#include <sstream>
#include <vector>

#include "tests/benchmarks/peers/mujoco_model.hpp"
#include "tests/benchmarks/peers/peer_engine.hpp"
#include "tests/benchmarks/peers/peer_geometry.hpp"
#include "world/physics/bodies/mass_properties.hpp"

namespace aprsim::bench {
namespace {

constexpr int kMostIterations = 50;

struct MujocoSettings {
  const char* name;
  double solref_s = 0.02;  ///< time constant of contacts; at least two steps
  bool accurate = false;   ///< elliptic cones, impratio 10, five no-slip iterations
};

constexpr MujocoSettings kMujocoSettings[] = {
    {"default", 0.02}, {"stiff", 0.002}, {"stiff, elliptic, no slip", 0.002, true}};

// Collision masks: what a geom is and what it collides with.
constexpr const char* kBelt = " contype=\"1\" conaffinity=\"2\"";
constexpr const char* kFloor = " contype=\"2\" conaffinity=\"1\"";
constexpr const char* kWall = " contype=\"4\" conaffinity=\"8\"";
constexpr const char* kGear = " contype=\"8\" conaffinity=\"12\"";

std::string numbers(std::initializer_list<double> values) {
  std::ostringstream out;
  out.precision(17);
  for (const double value : values) out << value << ' ';
  return out.str();
}

std::string body_head(const std::string& name, const Pose& pose,
                      const physics::MassProperties& mass) {
  const auto& i = mass.inertia;
  return "<body name=\"" + name + "\" pos=\"" + numbers({pose.p.x(), pose.p.y(), pose.p.z()}) +
         "\" quat=\"" + numbers({pose.q.w(), pose.q.x(), pose.q.y(), pose.q.z()}) +
         "\"><freejoint/><inertial pos=\"" + numbers({mass.com.x(), mass.com.y(), mass.com.z()}) +
         "\" mass=\"" + numbers({mass.mass_kg}) + "\" fullinertia=\"" +
         numbers({i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2)}) + "\"/>";
}

std::string box_geom(const PeerBox& box, const std::string& more) {
  return "<geom type=\"box\" pos=\"" + numbers({box.centre.x(), box.centre.y(), box.centre.z()}) +
         "\" size=\"" + numbers({box.half.x(), box.half.y(), box.half.z()}) + "\"" + more + "/>";
}

std::string friction(double mu) { return " friction=\"" + numbers({mu, 0.005, 0.0001}) + "\""; }

std::string tray_xml(const scene::Scene& scene, const scene::TrayInstance& tray) {
  const auto& type = scene.tray_types.at(tray.type);
  std::string out = body_head(tray.name, tray.X_WP, physics::tray_mass(type));
  for (const auto& box : tray_boxes(type)) {
    out += box_geom(box, box.floor ? kFloor + friction(scene.physics.friction.tray_belt)
                                   : kWall + friction(scene.physics.friction.gear_tray));
  }
  return out + "</body>\n";
}

std::string gear_xml(const scene::Scene& scene, const scene::GearInstance& gear) {
  const auto& type = scene.gear_types.at(gear.type);
  std::string out = body_head(gear.name, gear.X_WP, physics::gear_mass(type));
  for (const auto& cylinder : gear_cylinders(type)) {
    out += "<geom type=\"cylinder\" pos=\"" + numbers({0, 0, cylinder.z_centre}) + "\" size=\"" +
           numbers({cylinder.radius, cylinder.half_height}) + "\"" + kGear +
           friction(scene.physics.friction.gear_tray) + "/>";
  }
  return out + "</body>\n";
}

/// The belt is a body that slides along x with its velocity set anew before every step.
std::string belt_xml(const scene::Scene& scene) {
  const auto& belt = *scene.conveyor;
  return "<body name=\"belt\" pos=\"" +
         numbers({belt.X_WC.p.x(), belt.X_WC.p.y(), belt.X_WC.p.z() - 0.05}) +
         "\"><joint type=\"slide\" axis=\"1 0 0\"/><geom type=\"box\" mass=\"1e4\" size=\"" +
         numbers({3 * belt.length_m, belt.width_m, 0.05}) + "\"" + kBelt +
         friction(scene.physics.friction.tray_belt) + "/></body>\n";
}

std::string model_xml(const scene::Scene& scene, const MujocoSettings& settings) {
  std::string out =
      "<mujoco><size njmax=\"" + numbers({300.0 * double(scene.trays.size())}) + "\" nconmax=\"" +
      numbers({300.0 * double(scene.trays.size())}) + "\"/><option timestep=\"" +
      numbers({scene.physics.step_s}) + "\" gravity=\"" +
      numbers({0, 0, -scene.physics.gravity_m_s2}) + "\"" + " iterations=\"" +
      std::to_string(kMostIterations) + "\"" +
      (settings.accurate ? " cone=\"elliptic\" impratio=\"10\" noslip_iterations=\"5\"" : "") +
      "/><default><geom solref=\"" + numbers({settings.solref_s, 1}) +
      "\"/></default><worldbody>\n";
  out += belt_xml(scene);
  for (const auto& tray : scene.trays) out += tray_xml(scene, tray);
  for (const auto& gear : scene.gears) out += gear_xml(scene, gear);
  return out + "</worldbody></mujoco>\n";
}

class MujocoSimulation : public TraySimulation {
 public:
  MujocoSimulation(const scene::Scene& scene, const MujocoSettings& settings)
      : step_s_(scene.physics.step_s), model_(load_mujoco_model(model_xml(scene, settings))) {
    data_.reset(mj_makeData(model_.get()));
    mj_forward(model_.get(), data_.get());
  }

  void step(double belt_speed_m_s) override {
    data_->qvel[0] = belt_speed_m_s;
    mj_step(model_.get(), data_.get());
    travel_m_ += belt_speed_m_s * step_s_;
    data_->qpos[0] = travel_m_;
  }
  [[nodiscard]] Pose body(int index) const override {
    const mjtNum* q = data_->qpos + 1 + std::ptrdiff_t{7} * index;
    return {{q[0], q[1], q[2]}, Eigen::Quaterniond(q[3], q[4], q[5], q[6])};
  }
  [[nodiscard]] int contact_count() const override { return data_->ncon; }

 private:
  struct Delete {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };

  double step_s_, travel_m_ = 0;
  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_;
};

}  // namespace

PeerEngine mujoco_engine() {
  PeerEngine engine{
      .name = "MuJoCo", .short_name = "mujoco", .version = mj_versionString(), .settings = {}};
  for (const auto& settings : kMujocoSettings) {
    engine.settings.push_back({settings.name, [settings](const scene::Scene& scene) {
                                 return std::make_unique<MujocoSimulation>(scene, settings);
                               }});
  }
  return engine;
}

}  // namespace aprsim::bench
