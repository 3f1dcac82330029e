// Prints hashes of the default cell at work, and of one under random robot commands, in every mode
// of contact simplification: a line each simulated second. A change that is to keep the behaviour
// leaves every line as it was, and so does the pace at which it runs.
// usage: state_hashes [SECONDS [SPEED [MODE]]]
//   SECONDS  simulated, of each run (10)
//   SPEED    of simulated to wall time (0 = as fast as it goes)
//   MODE     off, virtual_joints, merge or dormant (all)

#include <bit>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <thread>

#include "tests/support/cell_script.hpp"
#include "tests/support/kitting_demo.hpp"

namespace aprsim::test {
namespace {

/// FNV-1a over 64-bit words.
class Digest {
 public:
  void add(std::uint64_t word) { hash_ = (hash_ ^ word) * 0x100000001b3ULL; }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) add(v(i));
  }
  void add(const std::string& text) {
    for (const char c : text) add(static_cast<std::uint64_t>(c));
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

/// Holds steps to the wall clock.
class Pace {
 public:
  explicit Pace(double speed) : speed_(speed) {}
  void wait(int step) const {
    if (speed_ <= 0) return;
    std::this_thread::sleep_until(begin_ +
                                  std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(1e-3 * step / speed_)));
  }

 private:
  using Clock = std::chrono::steady_clock;
  double speed_;
  Clock::time_point begin_ = Clock::now();
};

void add_robot(Digest& digest, const api::RobotSnapshot& robot) {
  for (const api::JointSnapshot& joint : robot.joints) {
    digest.add(joint.position_rad);
    digest.add(joint.velocity_rad_s);
    digest.add(joint.torque_nm);
  }
  digest.add(robot.X_RT.p);
  digest.add(robot.v_RT);
  digest.add(robot.force_T_R);
  digest.add(robot.torque_T_R);
  for (const double force : robot.gripper.force_n) digest.add(force);
  digest.add(static_cast<std::uint64_t>(robot.action.state));
  digest.add(robot.action.description);
}

void add_cell(Digest& digest, const world::World& world, const api::Snapshot& now) {
  digest.add(world.state_hash());
  for (const api::RobotSnapshot& robot : now.robots) add_robot(digest, robot);
  for (const api::BodySnapshot& body : now.bodies) digest.add(body.X_WB.p);
}

/// Random commands of a client, feasible or not.
class RandomCommands {
 public:
  explicit RandomCommands(std::uint64_t seed) : engine_(seed) {}

  api::RobotAction draw(const api::RobotSnapshot& robot, int joints) {
    switch (whole(0, 11)) {
      case 0:
        return api::InitRobot{};
      case 1:
        return api::StopMotion{static_cast<api::StopKind>(whole(0, 2))};
      case 2:
        return api::SetOverride{real(0.2, 1)};
      case 3:
        return api::SetGripper{real(0, 1)};
      case 4:
        return api::MoveThroughTo{{near(robot), near(robot), near(robot)}, whole(0, 1) == 1};
      case 5:
        return api::MoveScrew{.start = near(robot),
                              .axis_point_R = {},
                              .free_m = real(0, 0.02),
                              .screw_m = real(0, 0.02),
                              .turn_rad = real(-1, 1)};
      case 6:
      case 7: {
        const int joint = whole(0, joints - 1);
        const double q = robot.joints[static_cast<std::size_t>(joint)].position_rad;
        return api::MoveJoints{{{joint, q + real(-0.5, 0.5), real(0.1, 2), {}, {}, {}}}};
      }
      case 8:
        return api::SetMotionLimit{static_cast<api::MotionLimit>(whole(0, 3)), true, real(0.1, 1)};
      default:
        return api::MoveTo{near(robot).X_RT, whole(0, 1) == 1, {}, {}};
    }
  }
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }

 private:
  double real(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  api::Waypoint near(const api::RobotSnapshot& robot) {
    Pose X = robot.X_RT;
    X.p += Eigen::Vector3d(real(-0.1, 0.1), real(-0.1, 0.1), real(-0.06, 0.1));
    X.q = X.q * Eigen::Quaterniond(Eigen::AngleAxisd(real(-0.6, 0.6), Eigen::Vector3d::UnitZ()));
    return {X, {}, {}};
  }
  std::mt19937_64 engine_;
};

void print(const char* run, scene::Simplification mode, int second, const Digest& digest) {
  std::printf("%s mode %d second %d %016llx\n", run, static_cast<int>(mode), second,
              static_cast<unsigned long long>(digest.value()));
}

void at_work(const std::shared_ptr<const scene::Scene>& scene, int seconds, double speed) {
  const Pace pace(speed);
  world::World world(scene, 1);
  KittingDemo demo(world);
  Digest digest;
  for (int step = 1; step <= 1000 * seconds; ++step) {
    pace.wait(step);
    demo.advance();
    if (step % 10 == 0) add_cell(digest, world, demo.now());
    if (step % 1000 == 0) print("demo", scene->physics.simplification, step / 1000, digest);
  }
}

void under_random_commands(const std::shared_ptr<const scene::Scene>& scene, int seconds,
                           double speed) {
  const Pace pace(speed);
  world::World world(scene, 1);
  api::Snapshot now;
  world.write(now);
  RandomCommands commands(7);
  Digest digest;
  api::Ticket ticket = 0;
  const auto robots = static_cast<int>(now.robots.size());
  for (int step = 1; step <= 1000 * seconds; ++step) {
    if (step == 1 || commands.whole(0, 149) == 0) {
      for (int robot = 0; robot < robots; ++robot) {
        const auto index = static_cast<std::size_t>(robot);
        const api::RobotSnapshot& state = now.robots[index];
        const auto joints = static_cast<int>(world.description()->robots[index].joints.size());
        api::RobotAction action =
            state.initialized ? commands.draw(state, joints) : api::RobotAction(api::InitRobot{});
        world.apply(++ticket, api::RobotCommand{robot, std::move(action), {}});
      }
    }
    pace.wait(step);
    world.step();
    world.write(now);
    add_cell(digest, world, now);
    if (step % 1000 == 0) print("random", scene->physics.simplification, step / 1000, digest);
  }
}

}  // namespace
}  // namespace aprsim::test

int main(int argc, char** argv) {
  using namespace aprsim;
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 10;
  const double speed = argc > 2 ? std::atof(argv[2]) : 0;
  const std::string only = argc > 3 ? argv[3] : "";
  for (const auto& [mode, mode_name] :
       {std::pair(scene::Simplification::kOff, "off"),
        std::pair(scene::Simplification::kVirtualJoints, "virtual_joints"),
        std::pair(scene::Simplification::kMerge, "merge"),
        std::pair(scene::Simplification::kDormant, "dormant")}) {
    if (!only.empty() && only != mode_name) continue;
    for (const char* name : {"aprs", "aprs_2024"}) {
      auto scene = std::make_shared<scene::Scene>(*test::load_scene(name));
      scene->physics.simplification = mode;
      if (std::string(name) == "aprs") test::at_work(scene, seconds, speed);
      test::under_random_commands(scene, seconds, speed);
    }
  }
}
