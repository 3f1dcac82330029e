#include "world/scene/readers/crcl_joint_reader.hpp"

#include <charconv>
#include <string>

#include <Eigen/Core>
#include <Eigen/LU>

#include "world/scene/readers/reading.hpp"

namespace aprsim::scene {
namespace {

constexpr double kMaxPulses = 1e9;
constexpr const char* kNoJoint = "none";

/// 0-based; -1 for none and after an error.
int read_joint(const yaml::Node& node, std::size_t joint_count) {
  std::string text = node.text();
  if (text == kNoJoint) return -1;
  int number = 0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  if (read.ec == std::errc() && read.ptr == end && number >= 1 &&
      number <= static_cast<int>(joint_count)) {
    return number - 1;
  }
  node.unexpected("a joint of the model, 1 to " + std::to_string(joint_count) + ", or none");
  return -1;
}

void check_joint_alone(const yaml::Map& keys) {
  for (const char* key : {"pulses_per_deg", "reversed", "offset_deg", "coupling", "limits"}) {
    if (const yaml::Node node = keys[key]) {
      node.error(std::string(key) + " of joint none", "the key joint alone");
    }
  }
}

void read_coupling(const yaml::Node& node, std::size_t number, std::size_t count,
                   api::WireJoint& out) {
  for (const auto& [key, value] : node.entries()) {
    std::size_t other = 0;
    const char* end = key.data() + key.size();
    const auto read = std::from_chars(key.data(), end, other);
    if (read.ec != std::errc() || read.ptr != end || other < 1 || other > count ||
        other == number) {
      value.error("a coupling to \"" + key + '"',
                  "the number of another joint of this list, 1 to " + std::to_string(count));
      return;
    }
    out.couplings.push_back({static_cast<int>(other) - 1, value.number(yaml::between(-100, 100))});
  }
}

void read_limits(const yaml::Node& node, api::WireJoint& out) {
  if (!node) return;
  const auto limits = node.numbers<2>(yaml::between(-kMaxPulses, kMaxPulses));
  if (!(limits[0] < limits[1])) node.error("a lower limit not below the upper", "[LOWER, UPPER]");
  const auto angle = [&out](double value) {
    return out.counts_per_rad > 0 ? value / out.counts_per_rad : radians(value);
  };
  out.range = {angle(limits[0]), angle(limits[1])};
}

api::WireJoint read_wire_joint(const yaml::Node& node, std::size_t number, std::size_t count,
                               std::size_t joint_count) {
  const yaml::Map keys =
      node.map({"joint", "pulses_per_deg", "reversed", "offset_deg", "coupling", "limits"});
  api::WireJoint out;
  out.joint = read_joint(keys["joint"], joint_count);
  if (out.joint < 0) {
    check_joint_alone(keys);
    return out;
  }
  if (const yaml::Node pulses = keys["pulses_per_deg"]) {
    out.counts_per_rad =
        pulses.number({.min = 0, .max = kMaxPulses, .open_min = true}) / radians(1);
  }
  out.sign = keys["reversed"].boolean_or(false) ? -1 : 1;
  out.offset_rad = radians(keys["offset_deg"].number_or(0, yaml::between(-360, 360)));
  read_coupling(keys["coupling"], number, count, out);
  read_limits(keys["limits"], out);
  return out;
}

/// Whether the joints of the list can be found from those of the model.
bool solvable(const std::vector<api::WireJoint>& joints) {
  const auto size = static_cast<Eigen::Index>(joints.size());
  using Shares = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, api::kMaxWireJoints,
                               api::kMaxWireJoints>;
  Shares shares = Shares::Zero(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const api::WireJoint& joint = joints[static_cast<std::size_t>(i)];
    shares(i, i) = joint.sign;
    for (const api::JointShare& share : joint.couplings) shares(i, share.joint) += share.factor;
  }
  return Eigen::FullPivLU<Shares>(shares).isInvertible();
}

}  // namespace

std::vector<api::WireJoint> read_crcl_joints(const yaml::Node& node, std::size_t joint_count) {
  const std::vector<yaml::Node> items = node.items();
  if (node && (items.size() < joint_count || items.size() > api::kMaxWireJoints)) {
    node.error("a list of " + std::to_string(items.size()),
               "a list of " + std::to_string(joint_count) + " to " +
                   std::to_string(api::kMaxWireJoints) + " joints");
    return {};
  }
  std::vector<api::WireJoint> joints;
  std::vector<bool> there(joint_count, false);
  for (const yaml::Node& item : items) {
    joints.push_back(read_wire_joint(item, joints.size() + 1, items.size(), joint_count));
    const int joint = joints.back().joint;
    if (joint < 0) continue;
    if (there[static_cast<std::size_t>(joint)]) {
      item.error("joint " + std::to_string(joint + 1) + " a second time", "each joint once");
    }
    there[static_cast<std::size_t>(joint)] = true;
  }
  for (std::size_t i = 0; node && i < joint_count; ++i) {
    if (!there[i]) node.error("no joint " + std::to_string(i + 1), "each joint of the model once");
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    for (const api::JointShare& share : joints[i].couplings) {
      if (joints[static_cast<std::size_t>(share.joint)].joint >= 0) continue;
      items[i].error("a coupling to joint " + std::to_string(share.joint + 1) + ", which is none",
                     "couplings to joints of the model");
      return {};
    }
  }
  if (!joints.empty() && !solvable(joints)) {
    node.error("couplings that cancel each other", "joints that each move the arm on their own");
  }
  return joints;
}

std::optional<Pose> read_tool_point(const yaml::Node& node) {
  if (!node) return std::nullopt;
  if (node.is_map()) return read_pose_map(node);
  if (node.word({"tool", "flange"}) == 0) return std::nullopt;
  return Pose{};
}

}  // namespace aprsim::scene
