#pragma once

#include "aprsim/v1/journal.pb.h"
#include "server/journal/record_queue.hpp"

namespace aprsim::server::journal {

void write_time(WallTime time, google::protobuf::Timestamp& message);

/// Converts a queued entry or a gap to a journal record. Thread: any.
void write_message(const Entry& entry, v1::JournalRecord& record);
void write_message(const Missing& missing, v1::JournalRecord& record);

}  // namespace aprsim::server::journal
