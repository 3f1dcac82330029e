#pragma once

#include "world/api/faults/fault.hpp"
#include "world/api/faults/fault_kinds.hpp"
#include "world/base/fields.hpp"

/// The fields of faults and of the tables of their kinds; see world/base/fields.hpp.
namespace aprsim::faults {

APRSIM_FIELDS(Parameter, FIELD(name), FIELD(unit), FIELD(min), FIELD(max),
              FIELD_AS(fallback, default_), FIELD(meaning))
APRSIM_FIELDS(KindInfo, NOWHERE(kind), FIELD(name), BY_HAND(target), FIELD(momentary),
              FIELD(meaning), BY_HAND(parameters))
APRSIM_FIELDS(QuantityInfo, NOWHERE(quantity), FIELD(name), FIELD(unit), FIELD(of_robot),
              FIELD(meaning))

}  // namespace aprsim::faults

namespace aprsim::api {

APRSIM_FIELDS(AtTime, ALONE(time))
APRSIM_FIELDS(WhenPlaced, FIELD(type), FIELD(robot))
APRSIM_FIELDS(WhenGrasped, FIELD(robot), FIELD(count))
APRSIM_FIELDS(WhenBeamBroken, FIELD(eye))
APRSIM_FIELDS(WhenCrossing, BY_HAND(quantity), FIELD(robot), FIELD(joint), BY_HAND(above),
              BY_HAND(limit))
APRSIM_FIELDS(WhenReported, FIELD(event))
APRSIM_ALTERNATIVES(FaultTrigger, "trigger of a fault", NO_ALTERNATIVE, ALTERNATIVE(AtTime, at),
                    ALTERNATIVE(WhenPlaced, placed), ALTERNATIVE(WhenGrasped, grasped),
                    ALTERNATIVE(WhenBeamBroken, beam), ALTERNATIVE(WhenCrossing, crossing),
                    ALTERNATIVE(WhenReported, reported))

APRSIM_FIELDS(InjectFault, FIELD(kind), FIELD(target), FIELD(parameters), INLINED(trigger),
              FIELD(duration), NOWHERE(resolved))
APRSIM_FIELDS(EndFault, ALONE(id))
APRSIM_FIELDS(ReportEvent, ALONE(event))
APRSIM_ALTERNATIVES(FaultCommand, "command of faults", ALTERNATIVE(InjectFault, inject_fault),
                    ALTERNATIVE(EndFault, end_fault), ALTERNATIVE(ReportEvent, report_event))

APRSIM_FIELDS(InjectedFault, FIELD(id), FIELD(ticket), BY_HAND(kind), FIELD(target), FIELD(trigger),
              ARCHIVE_ONLY(robot), BY_HAND(values), FIELD(state), FIELD(begin_step),
              FIELD(end_step), FIELD(note))
APRSIM_FIELDS(InjectedFaults, BY_HAND(all))

}  // namespace aprsim::api
