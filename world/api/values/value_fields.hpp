#pragma once

#include "world/api/values/cell_event.hpp"
#include "world/api/values/guard.hpp"
#include "world/api/values/light_curtain.hpp"
#include "world/api/values/pose.hpp"
#include "world/api/values/wire_joint.hpp"
#include "world/base/fields.hpp"

/// The fields of the values of this folder; see world/base/fields.hpp.
namespace aprsim {

APRSIM_FIELDS(Pose, FIELD_AS(p, position_m), FIELD_AS(q, orientation))

namespace api {

APRSIM_FIELDS(Signal, FIELD_AS(kind, signal), FIELD(index), FIELD(reversed))
APRSIM_FIELDS(Guard, INLINED(signal), FIELD(limit), FIELD(value), FIELD(recheck),
              FIELD(require_trigger), FIELD(error_on_trigger), FIELD(label))
APRSIM_FIELDS(GuardSnapshot, ARCHIVE_ONLY(checks), ARCHIVE_ONLY(last_check),
              ARCHIVE_ONLY(last_value))
APRSIM_FIELDS(GuardsSnapshot, ARCHIVE_ONLY(ticket), ARCHIVE_ONLY(count), ARCHIVE_ONLY(guards),
              ARCHIVE_ONLY(triggers), ARCHIVE_ONLY(stop_time), ARCHIVE_ONLY(trigger_guard),
              ARCHIVE_ONLY(trigger_value), ARCHIVE_ONLY(trigger_X_RT))

APRSIM_FIELDS(LightCurtainDescription, FIELD_AS(X_WK, curtain_in_world), FIELD(beams),
              FIELD(pitch_m), FIELD(range_m), FIELD(reaction))
APRSIM_FIELDS(LightCurtainSnapshot, FIELD(broken), BY_HAND(distance_m))
APRSIM_FIELDS(Intruder, FIELD_AS(X_WI, intruder_in_world), FIELD(size_m))

APRSIM_FIELDS(JointShare, FIELD(joint), FIELD(factor))

APRSIM_FIELDS(CellEvent, FIELD(sequence), FIELD(epoch), FIELD(step), FIELD_AS(time, sim_time),
              FIELD(kind), FIELD(names), FIELD(text), FIELD(robot), FIELD(number))

}  // namespace api
}  // namespace aprsim
