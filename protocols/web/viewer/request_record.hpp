#pragma once

#include <string>

#include "protocols/web/viewer/viewer.hpp"
#include "protocols/web/viewer/web_options.hpp"

namespace aprsim::web {

/// Name of what is asked for, as the protocol has it; empty = it is unknown here.
[[nodiscard]] std::string kind_of(const v1::ViewerRequest& request);

/// Records what viewers ask of the cell, and whether it was taken: in the trace, in the audit,
/// among the commands of the wires, and as a rejection. Thread: the server's.
void record(const WebServerOptions& options, const api::CellDescription& cell, Viewer& viewer,
            const v1::ViewerRequest& request, const Result<void>& done);

}  // namespace aprsim::web
