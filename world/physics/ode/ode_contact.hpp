#pragma once

#include <ode/ode.h>

#include "world/physics/bodies/contact_constraint.hpp"
#include "world/physics/bodies/rigid_body.hpp"
#include "world/physics/engine/contact_setting.hpp"

namespace aprsim::physics {

/// A contact as ODE takes it: a friction pyramid proportional to the normal force (dContactApprox1)
/// with an edge along the slip; a gap as a limit of the normal velocity; a belt as a moving
/// surface. Bodies are null for the ground.
[[nodiscard]] dContact ode_contact(const RigidBody* a, const RigidBody* b,
                                   const ContactConstraint& constraint,
                                   const ContactSetting& setting);

}  // namespace aprsim::physics
