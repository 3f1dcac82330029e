#include "tests/benchmarks/wrist/crcl_arm.hpp"

#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "tests/support/pick_place.hpp"

namespace aprsim::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kGripHeight = 4e-3;  // of the tool tip over the disc [m]

world::SimulationOptions as_fast_as_possible() {
  world::SimulationOptions options;
  options.speed.reset();
  return options;
}

std::string vector(const char* name, const Eigen::Vector3d& v) {
  return fmt::format("<{0}><I>{1:.17g}</I><J>{2:.17g}</J><K>{3:.17g}</K></{0}>", name, v.x(), v.y(),
                     v.z());
}

}  // namespace

CrclArm::CrclArm(int robot, const std::string& part)
    : simulation_(test::load_scene("aprs"), as_fast_as_possible()),
      robot_(static_cast<std::size_t>(robot)) {
  const auto& bodies = simulation_.latest()->cell->bodies;
  while (part_ < bodies.size() && bodies[part_].name != part) ++part_;
  if (part_ == bodies.size()) throw std::runtime_error("no body " + part);
  crcl_server::CrclServerOptions options;
  options.listener.port = 0;
  options.robot = robot;
  options.wait_for_end_effector = true;
  server_ = std::make_unique<crcl_server::CrclServer>(options, simulation_, simulation_);
  const auto port = server_->start();
  if (!port) throw std::runtime_error(port.error().message);
  simulation_.start();
  client_ = std::make_unique<test::CrclTextClient>(*port);
  client_->run("InitCanonType");
}

CrclArm::~CrclArm() {
  client_.reset();
  server_.reset();
  simulation_.stop();
}

bool CrclArm::move(const Eigen::Isometry3d& X_WT, bool straight) {
  const auto& robot = simulation_.latest()->cell->robots[robot_];
  const Eigen::Isometry3d X_RT = (robot.X_WB.isometry() * robot.X_BR.isometry()).inverse() * X_WT;
  const Eigen::Vector3d mm = 1e3 * X_RT.translation();
  try {
    client_->run(
        "MoveToType",
        fmt::format("<MoveStraight>{}</MoveStraight><EndPosition><Point><X>{:.17g}</X>"
                    "<Y>{:.17g}</Y><Z>{:.17g}</Z></Point>{}{}</EndPosition>",
                    straight, mm.x(), mm.y(), mm.z(), vector("XAxis", X_RT.linear().col(0)),
                    vector("ZAxis", X_RT.linear().col(2))));
  } catch (const std::runtime_error& error) {
    if (std::string(error.what()).find("CRCL_Error") == std::string::npos) throw;
    // A robot that has refused a command stays in error until it is initialized.
    client_->run("InitCanonType");
    set_speed(speed_m_s_, speed_rad_s_);
    return false;
  }
  return true;
}

void CrclArm::set_speed(double m_s, double rad_s) {
  speed_m_s_ = m_s;
  speed_rad_s_ = rad_s;
  client_->run("SetTransSpeedType",
               fmt::format("<TransSpeed xsi:type=\"TransSpeedAbsoluteType\"><Setting>{}</Setting>"
                           "</TransSpeed>",
                           1e3 * m_s));
  client_->run("SetRotSpeedType",
               fmt::format("<RotSpeed xsi:type=\"RotSpeedAbsoluteType\"><Setting>{}</Setting>"
                           "</RotSpeed>",
                           rad_s / kDegree));
}

void CrclArm::set_gripper(double setting) {
  client_->run("SetEndEffectorType", fmt::format("<Setting>{}</Setting>", setting));
}

void CrclArm::dwell(double seconds) {
  client_->run("DwellType", fmt::format("<DwellTime>{}</DwellTime>", seconds));
}

Eigen::Isometry3d CrclArm::grip() const {
  const auto now = simulation_.latest();
  const double height = now->cell->bodies[part_].disc_height_m + kGripHeight;
  return test::tool_down(now->bodies[part_].X_WB.isometry() * Eigen::Vector3d(0, 0, height), 0);
}

Eigen::Isometry3d CrclArm::place() const {
  const auto now = simulation_.latest();
  return now->robots[robot_].X_WT.isometry().inverse() * now->bodies[part_].X_WB.isometry();
}

bool CrclArm::holding() const { return simulation_.latest()->robots[robot_].gripper.holding; }

}  // namespace aprsim::bench
