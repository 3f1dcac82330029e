#pragma once

namespace aprsim::process {

/// Ends this process as SIGTERM does once its standard input ends. The starting program holds the
/// other end of the pipe, which closes however that program dies. A process that does not end
/// within 30 s is killed. Call once. Thread: any; a thread of its own waits.
void stop_when_input_ends();

}  // namespace aprsim::process
