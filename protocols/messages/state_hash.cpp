#include "protocols/messages/state_hash.hpp"

#include <bit>

namespace aprsim::protocols {
namespace {

class StateHash {
 public:
  void add(std::uint64_t bits) {
    for (int byte = 0; byte < 8; ++byte) {
      value_ = (value_ ^ ((bits >> (8 * byte)) & 0xff)) * 0x100000001b3ULL;
    }
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
  void add(const Eigen::Vector3d& v) {
    for (const double number : v) add(number);
  }
  void add(const Pose& pose) {
    add(pose.p);
    for (const double number : pose.q.coeffs()) add(number);
  }

  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

}  // namespace

std::uint64_t state_hash(const api::Snapshot& snapshot) {
  StateHash hash;
  hash.add(snapshot.step);
  for (const auto& body : snapshot.bodies) {
    hash.add(body.X_WB);
    hash.add(body.v_W);
    hash.add(body.omega_W);
  }
  for (const auto& tool : snapshot.tools) hash.add(tool.X_WT);
  for (const auto& robot : snapshot.robots) {
    for (const auto& joint : robot.joints) {
      hash.add(joint.position_rad);
      hash.add(joint.velocity_rad_s);
    }
    hash.add(robot.gripper.separation_m);
  }
  hash.add(snapshot.conveyor.travel_m);
  for (const auto& device : snapshot.devices) {
    for (const double signal : device.signals) hash.add(signal);
  }
  return hash.value();
}

}  // namespace aprsim::protocols
