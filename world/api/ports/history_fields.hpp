#pragma once

#include "world/api/ports/history.hpp"
#include "world/base/fields.hpp"

/// The fields of the history; see world/base/fields.hpp.
namespace aprsim::api {

APRSIM_FIELDS(Moment, FIELD(epoch), FIELD(step))
APRSIM_FIELDS(HistorySpan, FIELD(epoch), FIELD(first_step), FIELD(last_step), FIELD(first_time),
              FIELD(last_time), FIELD(seed), FIELD(loaded_state))
APRSIM_FIELDS(Bookmark, FIELD(id), FIELD(moment), FIELD_AS(time, sim_time), FIELD(kind),
              FIELD(text))

}  // namespace aprsim::api
