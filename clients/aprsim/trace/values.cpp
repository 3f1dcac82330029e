#include "clients/aprsim/trace/values.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace aprsim::trace {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kMany = 1e6;  // ratio for values without a tolerance

/// Display unit of a quantity.
struct Unit {
  const char* name;  ///< with the blank before it
  double factor;     ///< from SI
  int decimals;
  const char* more;  ///< of a larger magnitude
  const char* less;
};

Unit unit_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::kLength:
      return {" mm", 1e3, 2, "farther", "nearer"};
    case Quantity::kAngle:
      return {" deg", kDegrees, 2, "farther", "less far"};
    case Quantity::kSpeed:
      return {" mm/s", 1e3, 1, "faster", "slower"};
    case Quantity::kAcceleration:
      return {" mm/s^2", 1e3, 0, "more", "less"};
    case Quantity::kTurnSpeed:
      return {" deg/s", kDegrees, 1, "faster", "slower"};
    case Quantity::kTurnAcceleration:
      return {" deg/s^2", kDegrees, 0, "more", "less"};
    case Quantity::kWait:
      return {" s", 1, 3, "longer", "shorter"};
    case Quantity::kShare:
      return {" %", 100, 1, "more", "less"};
    case Quantity::kTorque:
      return {" Nm", 1, 2, "more", "less"};
    case Quantity::kCount:
      return {"", 1, 0, "more", "less"};
    case Quantity::kNumber:
      break;
  }
  return {"", 1, -1, "more", "less"};
}

std::string with_unit(const Unit& unit, double value) {
  return unit.decimals < 0
             ? fmt::format("{:.9g}{}", value * unit.factor, unit.name)
             : fmt::format("{:.{}f}{}", value * unit.factor, unit.decimals, unit.name);
}

double limit_of(Quantity quantity, double size, const Tolerance& tolerance) {
  switch (quantity) {
    case Quantity::kLength:
      return 1e-3 * tolerance.position_mm;
    case Quantity::kAngle:
      return tolerance.angle_deg / kDegrees;
    case Quantity::kSpeed:
    case Quantity::kAcceleration:
    case Quantity::kTurnSpeed:
    case Quantity::kTurnAcceleration:
    case Quantity::kTorque:
      return 0.01 * tolerance.rate_percent * size;
    case Quantity::kWait:
      return tolerance.wait_s;
    case Quantity::kShare:
      return tolerance.setting;
    case Quantity::kCount:
      return tolerance.register_counts;
    case Quantity::kNumber:
      break;
  }
  return 1e-9 * size;
}

}  // namespace

const std::vector<ToleranceName>& tolerance_names() {
  static const std::vector<ToleranceName> kNames = {
      {"position_mm", &Tolerance::position_mm, "commanded positions"},
      {"angle_deg", &Tolerance::angle_deg, "commanded joints and orientations"},
      {"rate_percent", &Tolerance::rate_percent, "speeds, accelerations, torques"},
      {"setting", &Tolerance::setting, "shares of 1, such as the gripper's setting"},
      {"wait_s", &Tolerance::wait_s, "commanded waits"},
      {"register_counts", &Tolerance::register_counts, "values written to registers"},
      {"time_s", &Tolerance::time_s, "durations and pauses"},
      {"time_percent", &Tolerance::time_percent,
       "durations and pauses; the larger tolerance counts"},
      {"end_mm", &Tolerance::end_mm, "reported end positions"},
      {"end_deg", &Tolerance::end_deg, "reported end joints and orientations"},
      {"seen_mm", &Tolerance::seen_mm, "final positions seen by cameras"},
      {"seen_deg", &Tolerance::seen_deg, "final orientations of trays seen by cameras"},
  };
  return kNames;
}

double Difference::weight() const { return limit > 0 ? std::min(amount / limit, kMany) : kMany; }

std::optional<Difference> difference(const Value& a, const Value& b, const Tolerance& tolerance) {
  const auto* x = std::get_if<Number>(&a);
  const auto* y = std::get_if<Number>(&b);
  if (x != nullptr && y != nullptr && x->quantity == y->quantity) {
    const double limit =
        limit_of(x->quantity, std::max(std::abs(x->value), std::abs(y->value)), tolerance);
    const double amount = std::abs(y->value - x->value);
    // A difference equal to the limit is allowed, despite rounding.
    if (amount <= limit * (1 + 1e-9)) return std::nullopt;
    return Difference{amount, limit};
  }
  const auto* p = std::get_if<Eigen::Quaterniond>(&a);
  const auto* q = std::get_if<Eigen::Quaterniond>(&b);
  if (p != nullptr && q != nullptr) {
    const double limit = tolerance.angle_deg / kDegrees, amount = p->angularDistance(*q);
    if (amount <= limit) return std::nullopt;
    return Difference{amount, limit};
  }
  const auto* s = std::get_if<std::string>(&a);
  const auto* t = std::get_if<std::string>(&b);
  if (s != nullptr && t != nullptr && *s == *t) return std::nullopt;
  return Difference{1, 0};
}

std::string text_of(const Value& value) {
  if (const auto* number = std::get_if<Number>(&value)) {
    return with_unit(unit_of(number->quantity), number->value);
  }
  if (const auto* turn = std::get_if<Eigen::Quaterniond>(&value)) {
    const Eigen::Matrix3d axes = turn->toRotationMatrix();
    return fmt::format("x axis ({:.3f}, {:.3f}, {:.3f}), z axis ({:.3f}, {:.3f}, {:.3f})",
                       axes(0, 0), axes(1, 0), axes(2, 0), axes(0, 2), axes(1, 2), axes(2, 2));
  }
  return std::get<std::string>(value);
}

std::string difference_text(const std::string& name, const Value& a, const Value& b) {
  const auto* x = std::get_if<Number>(&a);
  const auto* y = std::get_if<Number>(&b);
  if (x != nullptr && y != nullptr && x->quantity == y->quantity) {
    const Unit unit = unit_of(x->quantity);
    const double more = std::abs(y->value) - std::abs(x->value);
    const bool other_side = x->value * y->value < 0;
    return fmt::format(
        "{} {} {} ({}, was {})", name, with_unit(unit, std::abs(y->value - x->value)),
        other_side ? "away" : (more > 0 ? unit.more : unit.less), text_of(b), text_of(a));
  }
  const auto* p = std::get_if<Eigen::Quaterniond>(&a);
  const auto* q = std::get_if<Eigen::Quaterniond>(&b);
  if (p != nullptr && q != nullptr) {
    return fmt::format("{} turned by {:.2f} deg ({}, was {})", name,
                       kDegrees * p->angularDistance(*q), text_of(b), text_of(a));
  }
  return fmt::format("{} is {}, was {}", name, text_of(b), text_of(a));
}

}  // namespace aprsim::trace
