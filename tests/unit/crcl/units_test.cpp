#include "crcl/units.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace aprsim::crcl {
namespace {

TEST(Units, MatchTheDefinitions) {
  EXPECT_DOUBLE_EQ(to_si(1, LengthUnit::kInch), 0.0254);
  EXPECT_EQ(to_si(250, LengthUnit::kMillimeter), 0.25);
  EXPECT_EQ(to_si(0.3, LengthUnit::kMeter), 0.3);
  EXPECT_DOUBLE_EQ(to_si(180, AngleUnit::kDegree), std::numbers::pi);
  EXPECT_DOUBLE_EQ(to_si(1, ForceUnit::kPound), 4.4482216152605);
  EXPECT_DOUBLE_EQ(to_si(16, ForceUnit::kOunce), 4.4482216152605);
  EXPECT_DOUBLE_EQ(to_si(1, TorqueUnit::kFootPound), 1.3558179483314004);
}

template <typename Unit>
void expect_inverse(std::initializer_list<Unit> units) {
  for (const Unit unit : units) {
    for (const double value : {0.0, 1.0, -3.25, 809.9999999999999, 1e-9}) {
      EXPECT_DOUBLE_EQ(from_si(to_si(value, unit), unit), value) << name_of(unit);
    }
  }
}

TEST(Units, ConvertBackAndForth) {
  expect_inverse({LengthUnit::kMeter, LengthUnit::kMillimeter, LengthUnit::kInch});
  expect_inverse({AngleUnit::kRadian, AngleUnit::kDegree});
  expect_inverse({ForceUnit::kNewton, ForceUnit::kPound, ForceUnit::kOunce});
  expect_inverse({TorqueUnit::kNewtonMeter, TorqueUnit::kFootPound});
}

TEST(Units, NamesAreTheSchemas) {
  EXPECT_EQ(unit_named<LengthUnit>("millimeter"), LengthUnit::kMillimeter);
  EXPECT_EQ(unit_named<LengthUnit>("meter"), LengthUnit::kMeter);
  EXPECT_EQ(unit_named<LengthUnit>("inch"), LengthUnit::kInch);
  EXPECT_EQ(unit_named<LengthUnit>("mm"), std::nullopt);
  EXPECT_EQ(unit_named<AngleUnit>("radian"), AngleUnit::kRadian);
  EXPECT_EQ(unit_named<AngleUnit>("degree"), AngleUnit::kDegree);
  EXPECT_EQ(unit_named<ForceUnit>("ounce"), ForceUnit::kOunce);
  EXPECT_EQ(unit_named<TorqueUnit>("footPound"), TorqueUnit::kFootPound);
  EXPECT_EQ(name_of(TorqueUnit::kNewtonMeter), "newtonMeter");
}

TEST(Units, BeginAsTheReferenceServersDo) {
  const Units units;
  EXPECT_EQ(units.length, LengthUnit::kMillimeter);
  EXPECT_EQ(units.angle, AngleUnit::kDegree);
  EXPECT_EQ(units.force, ForceUnit::kNewton);
  EXPECT_EQ(units.torque, TorqueUnit::kNewtonMeter);
}

}  // namespace
}  // namespace aprsim::crcl
