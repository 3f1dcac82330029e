#pragma once

#include <string>

#include "protocols/web/viewer/viewer.hpp"
#include "protocols/web/viewer/web_options.hpp"

namespace aprsim::web {

/// Name of the request in the protocol; empty = unknown.
[[nodiscard]] std::string kind_of(const v1::ViewerRequest& request);

/// Records a viewer's request and its outcome in the trace, the audit and the list of commands;
/// also the rejection of a refused one. Thread: the server's.
void record(const WebServerOptions& options, const api::CellDescription& cell, Viewer& viewer,
            const v1::ViewerRequest& request, const Result<void>& done);

}  // namespace aprsim::web
