#include "protocols/crcl/joint_map.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <Eigen/LU>
#include <spdlog/fmt/fmt.h>

#include "protocols/crcl/significant_digits.hpp"

namespace aprsim::crcl_server {
namespace {

constexpr double kNothing = 1e-12;  // rounding of a share that is 0
constexpr crcl::LengthUnit kSlideUnit = crcl::LengthUnit::kMillimeter;

std::vector<api::WireJoint> wire_joints(const api::RobotDescription& robot) {
  if (!robot.wire_joints.empty()) return robot.wire_joints;
  std::vector<api::WireJoint> joints(robot.joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) joints[i].joint = static_cast<int>(i);
  return joints;
}

// A product that gives the same bits as its one term where there is only one.
Eigen::VectorXd times(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& values) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(matrix.rows());
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      const double factor = matrix(row, column);
      if (factor != 0) out(row) += factor * values(column);
    }
  }
  return out;
}

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

bool names(const std::string& text, const std::string& word) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !is_word(text[at - 1])) && (end == text.size() || !is_word(text[end]))) {
      return true;
    }
  }
  return false;
}

// The sum of the values that are set, weighted by their shares in the arm's joint; empty if one is
// unset.
std::optional<double> sum_of(const std::vector<WireTarget>& targets, const Eigen::MatrixXd& to_arm,
                             Eigen::Index row, std::optional<double> WireTarget::*value) {
  double sum = 0;
  for (const WireTarget& target : targets) {
    const double share = std::abs(to_arm(row, target.number - 1));
    if (share == 0) continue;
    if (!(target.*value)) return std::nullopt;
    sum += share * *(target.*value);
  }
  return sum;
}

}  // namespace

JointMap::JointMap(const api::RobotDescription& robot)
    : wire_(wire_joints(robot)), arm_(robot.joints) {
  const auto joints = static_cast<Eigen::Index>(arm_.size());
  const auto wires = static_cast<Eigen::Index>(wire_.size());
  to_arm_ = Eigen::MatrixXd::Zero(joints, wires);
  to_wire_ = Eigen::MatrixXd::Zero(wires, joints);
  offset_ = Eigen::VectorXd::Zero(joints);
  std::vector<Eigen::Index> used;  // wire joints that the arm has
  for (Eigen::Index i = 0; i < wires; ++i) {
    const api::WireJoint& wire = wire_[static_cast<std::size_t>(i)];
    if (wire.joint < 0) continue;
    const bool again = std::ranges::any_of(used, [&](Eigen::Index other) {
      return wire_[static_cast<std::size_t>(other)].joint == wire.joint;
    });
    if (wire.joint >= joints || again) throw std::invalid_argument("CRCL joints: bad joint");
    used.push_back(i);
    to_arm_(wire.joint, i) += wire.sign;
    offset_(wire.joint) = wire.offset_rad;
    for (const api::JointShare& share : wire.couplings) {
      to_arm_(wire.joint, share.joint) += share.factor;
    }
  }
  if (static_cast<Eigen::Index>(used.size()) != joints) {
    throw std::invalid_argument("CRCL joints: one of the arm's is missing");
  }
  // The inverse, over the joints that there are.
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, api::kMaxWireJoints,
                               api::kMaxWireJoints>;
  Square square(joints, joints);
  for (Eigen::Index i = 0; i < joints; ++i) {
    square.col(i) = to_arm_.col(used[static_cast<std::size_t>(i)]);
  }
  const Eigen::FullPivLU<Square> factors(square);
  if (!factors.isInvertible()) throw std::invalid_argument("CRCL joints: couplings are singular");
  const Square inverse = factors.inverse();
  for (Eigen::Index i = 0; i < joints; ++i) {
    to_wire_.row(used[static_cast<std::size_t>(i)]) =
        (inverse.row(i).array().abs() < kNothing).select(0.0, inverse.row(i));
  }
}

int JointMap::number_of(int arm_joint) const {
  const auto found = std::ranges::find(wire_, arm_joint, &api::WireJoint::joint);
  return static_cast<int>(found - wire_.begin()) + 1;
}

double JointMap::to_rad(int number, double value, crcl::AngleUnit unit) const {
  const double counts = at(number).counts_per_rad;
  if (counts > 0) return value / counts;
  return slides(number) ? crcl::to_si(value, kSlideUnit) : crcl::to_si(value, unit);
}

double JointMap::from_rad(int number, double rad, crcl::AngleUnit unit) const {
  const double counts = at(number).counts_per_rad;
  if (counts > 0) return rad * counts;
  return slides(number) ? crcl::from_si(rad, kSlideUnit) : crcl::from_si(rad, unit);
}

double JointMap::reported(int number, double rad, crcl::AngleUnit unit) const {
  const double value = from_rad(number, rad, unit);
  if (at(number).counts_per_rad > 0) return rounded(value, kPulseDecimals);
  return rounded(value, slides(number) ? decimals_of(kSlideUnit) : decimals_of(unit));
}

std::string_view JointMap::unit_name(int number, crcl::AngleUnit unit) const {
  if (at(number).counts_per_rad > 0) return "pulse";
  return slides(number) ? crcl::name_of(kSlideUnit) : crcl::name_of(unit);
}

Eigen::VectorXd JointMap::wire_angles(const Eigen::VectorXd& arm_rad) const {
  return times(to_wire_, arm_rad - offset_);
}

Eigen::VectorXd JointMap::wire_rates(const Eigen::VectorXd& arm_rad_s) const {
  return times(to_wire_, arm_rad_s);
}

Eigen::VectorXd JointMap::arm_angles(const Eigen::VectorXd& wire_rad) const {
  return times(to_arm_, wire_rad) + offset_;
}

api::AngleRange JointMap::range(int number) const {
  const api::WireJoint& wire = at(number);
  if (wire.has_range() || wire.joint < 0) return wire.range;
  api::AngleRange range;
  for (Eigen::Index i = 0; i < to_wire_.cols(); ++i) {
    const double share = to_wire_(number - 1, i);
    if (share == 0) continue;
    const api::JointDescription& joint = arm_[static_cast<std::size_t>(i)];
    const double lower = share * (joint.lower_rad - offset_(i));
    const double upper = share * (joint.upper_rad - offset_(i));
    range.lower_rad += std::min(lower, upper);
    range.upper_rad += std::max(lower, upper);
  }
  return range;
}

api::MoveJoints JointMap::to_move(const std::vector<WireTarget>& targets) const {
  // With N the named wire joints and U the others, which stay at what the arm's held joints say:
  // arm = to_arm (N angles + U to_wire (held - offset)) + offset.
  Eigen::VectorXd named = Eigen::VectorXd::Zero(count());
  Eigen::MatrixXd others = to_wire_;
  for (const WireTarget& target : targets) {
    named(target.number - 1) = target.angle_rad;
    others.row(target.number - 1).setZero();
  }
  const Eigen::VectorXd position = arm_angles(named);
  const Eigen::MatrixXd held = to_arm_ * others;
  api::MoveJoints move;
  const auto add = [&](int joint, const WireTarget* own) {
    api::JointTarget& out = move.targets.emplace_back();
    out.joint = joint;
    out.position_rad = position(joint);
    for (Eigen::Index k = 0; k < held.cols(); ++k) {
      const double share = held(joint, k);
      if (std::abs(share) < kNothing) continue;
      out.held.push_back({static_cast<int>(k), share});
      out.position_rad -= share * offset_(k);
    }
    out.speed_rad_s = sum_of(targets, to_arm_, joint, &WireTarget::speed_rad_s);
    out.accel_rad_s2 = sum_of(targets, to_arm_, joint, &WireTarget::accel_rad_s2);
    if (own == nullptr) return;
    out.torque = own->torque;
    out.tolerance_rad = own->tolerance_rad;
  };
  // The named joints, then those coupled with them.
  for (const WireTarget& target : targets) {
    if (arm_joint(target.number) >= 0) add(arm_joint(target.number), &target);
  }
  for (int joint = 0; joint < static_cast<int>(arm_.size()); ++joint) {
    const bool moved = std::ranges::any_of(
        targets, [&](const WireTarget& t) { return to_arm_(joint, t.number - 1) != 0; });
    const bool there = std::ranges::any_of(
        move.targets, [&](const api::JointTarget& t) { return t.joint == joint; });
    if (moved && !there) add(joint, nullptr);
  }
  return move;
}

std::string JointMap::explained(std::string text) const {
  std::string added;
  for (std::size_t i = 0; i < arm_.size(); ++i) {
    if (arm_[i].name.empty() || !names(text, arm_[i].name)) continue;
    added += "; " + arm_[i].name + explanation(static_cast<int>(i));
  }
  return added.empty() ? text : std::move(text) + added;
}

std::string JointMap::explanation(int arm_joint) const {
  const int number = number_of(arm_joint);
  std::string text = fmt::format(" is CRCL joint {}", number);
  for (const api::JointShare& share : at(number).couplings) {
    text += fmt::format(" with {:g} of joint {}", share.factor, share.joint + 1);
  }
  if (at(number).counts_per_rad <= 0) return text;
  const api::AngleRange bounds = range(number);
  return text + fmt::format(", {:.0f} to {:.0f} {}s",
                            from_rad(number, bounds.lower_rad, crcl::AngleUnit::kDegree),
                            from_rad(number, bounds.upper_rad, crcl::AngleUnit::kDegree),
                            unit_name(number, crcl::AngleUnit::kDegree));
}

}  // namespace aprsim::crcl_server
