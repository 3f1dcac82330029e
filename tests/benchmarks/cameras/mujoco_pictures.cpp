#include "tests/benchmarks/cameras/mujoco_pictures.hpp"

#include <GL/osmesa.h>
#include <cmath>
#include <cstdlib>
#include <mujoco/mujoco.h>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "tests/benchmarks/peers/mujoco_model.hpp"
#include "world/scene/model/free_body.hpp"

namespace aprsim::bench {
namespace {

std::string vector_text(const Eigen::Vector3d& v) {
  return fmt::format("{} {} {}", v.x(), v.y(), v.z());
}

std::string pose_text(const Pose& X) {
  return fmt::format("pos=\"{}\" quat=\"{} {} {} {}\"", vector_text(X.p), X.q.w(), X.q.x(), X.q.y(),
                     X.q.z());
}

std::string box(const Pose& X, const Eigen::Vector3d& size, const char* colour) {
  return fmt::format("<geom type=\"box\" {} size=\"{}\" rgba=\"{}\"/>\n", pose_text(X),
                     vector_text(0.5 * size), colour);
}

std::string gear(const Pose& X, const api::BodyDescription& body) {
  return fmt::format(
      "<body {}><geom type=\"cylinder\" pos=\"0 0 {}\" size=\"{} {}\" rgba=\"0.2 0.6 0.2 1\"/>"
      "<geom type=\"cylinder\" pos=\"0 0 {}\" size=\"{} {}\" rgba=\"0.2 0.6 0.2 1\"/></body>\n",
      pose_text(X), 0.5 * body.disc_height_m, body.disc_radius_m, 0.5 * body.disc_height_m,
      0.5 * body.peg_top_m, body.peg_radius_m, 0.5 * body.peg_top_m);
}

/// MuJoCo's cameras look along -z with y up; ours along z with y down.
std::string camera(const scene::Camera& camera) {
  const Pose X{camera.X_PC.p, camera.X_PC.q * Eigen::Quaterniond(0, 1, 0, 0)};
  const double fovy = 2 * std::atan(0.5 * camera.lens.height_px / camera.lens.focal_px.y());
  return fmt::format("<camera name=\"c\" {} fovy=\"{}\"/>\n", pose_text(X),
                     fovy * 180 / std::numbers::pi);
}

std::string model_text(const scene::Scene& scene, const api::Snapshot& snapshot, int width,
                       int height) {
  std::string out = fmt::format(
      "<mujoco><visual><global offwidth=\"{}\" offheight=\"{}\"/>"
      "<quality shadowsize=\"2048\" offsamples=\"0\"/></visual><worldbody>\n"
      "<light pos=\"0 0 3.5\" dir=\"0 0 -1\" castshadow=\"true\"/>\n"
      "<geom type=\"plane\" size=\"5 5 0.1\" rgba=\"0.6 0.6 0.6 1\"/>\n",
      width, height);
  for (const auto& fixed : scene.fixed) out += box(fixed.X_WS, fixed.size, "0.9 0.9 0.87 1");
  if (scene.conveyor) {
    Pose under = scene.conveyor->X_WC;
    under.p.z() -= 0.05;
    out += box(under, {scene.conveyor->length_m, scene.conveyor->width_m, 0.1}, "0.3 0.3 0.3 1");
  }
  const auto& bodies = snapshot.cell->bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Pose& X_WB = snapshot.bodies[i].X_WB;
    if (bodies[i].kind == api::BodyKind::kGear) {
      out += gear(X_WB, bodies[i]);
      continue;
    }
    Pose X = X_WB;
    X.p += X_WB.q * Eigen::Vector3d(0.5 * (bodies[i].box_min + bodies[i].box_max));
    out += box(X, bodies[i].box_max - bodies[i].box_min, "0.1 0.1 0.1 1");
  }
  return out + camera(scene.cameras.at(0)) + "</worldbody></mujoco>\n";
}

}  // namespace

class MujocoPictures::Impl {
 public:
  Impl(const scene::Scene& scene, const api::Snapshot& snapshot, int width, int height)
      : view_{0, 0, width, height}, buffer_(pixels() * 4), rgb_(pixels() * 3), depth_(pixels()) {
    // Mesa renders in the calling thread.
    setenv("LP_NUM_THREADS", "0", 1);
    context_ = OSMesaCreateContextExt(GL_RGBA, 24, 8, 8, nullptr);
    if (context_ == nullptr ||
        OSMesaMakeCurrent(context_, buffer_.data(), GL_UNSIGNED_BYTE, width, height) == 0) {
      throw std::runtime_error("MuJoCo: there is no software OpenGL");
    }
    model_ = load_mujoco_model(model_text(scene, snapshot, width, height));
    data_ = mj_makeData(model_);
    mj_forward(model_, data_);
    mjv_defaultOption(&option_);
    mjv_defaultScene(&scene_);
    mjr_defaultContext(&renderer_);
    mjv_makeScene(model_, &scene_, 1000);
    mjr_makeContext(model_, &renderer_, mjFONTSCALE_100);
    mjr_setBuffer(mjFB_OFFSCREEN, &renderer_);
    mjv_defaultCamera(&camera_);
    camera_.type = mjCAMERA_FIXED;
    camera_.fixedcamid = 0;
  }
  ~Impl() {
    mjr_freeContext(&renderer_);
    mjv_freeScene(&scene_);
    mj_deleteData(data_);
    mj_deleteModel(model_);
    OSMesaDestroyContext(context_);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  double draw() {
    mjv_updateScene(model_, data_, &option_, nullptr, &camera_, mjCAT_ALL, &scene_);
    mjr_render(view_, &scene_, &renderer_);
    mjr_readPixels(rgb_.data(), depth_.data(), view_, &renderer_);
    return std::accumulate(rgb_.begin(), rgb_.end(), 0.0) / static_cast<double>(rgb_.size());
  }

 private:
  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(view_.width) * static_cast<std::size_t>(view_.height);
  }

  mjrRect view_;
  std::vector<std::uint8_t> buffer_, rgb_;
  std::vector<float> depth_;
  OSMesaContext context_ = nullptr;
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
  mjvOption option_{};
  mjvScene scene_{};
  mjvCamera camera_{};
  mjrContext renderer_{};
};

MujocoPictures::MujocoPictures(const scene::Scene& scene, const api::Snapshot& snapshot, int width,
                               int height)
    : impl_(std::make_unique<Impl>(scene, snapshot, width, height)) {}
MujocoPictures::~MujocoPictures() = default;
double MujocoPictures::draw() { return impl_->draw(); }
std::string MujocoPictures::version() { return mj_versionString(); }

}  // namespace aprsim::bench
