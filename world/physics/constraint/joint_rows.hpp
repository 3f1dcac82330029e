#pragma once

#include "world/physics/constraint/constraint_system.hpp"

/// Joints as rows of a ConstraintSystem, at the bodies' present poses.
namespace aprsim::physics {

void add_rows(const FixedJoint& joint, ConstraintSystem& system);
void add_rows(const SliderJoint& joint, ConstraintSystem& system);
void add_rows(const HingeJoint& joint, ConstraintSystem& system);
void add_rows(const RodJoint& joint, ConstraintSystem& system);

}  // namespace aprsim::physics
