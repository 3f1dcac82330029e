#pragma once

#include "aprsim/v1/journal.pb.h"
#include "server/journal/record_queue.hpp"

namespace aprsim::server::journal {

void write_time(WallTime time, google::protobuf::Timestamp& message);

/// What was told, as a record of the journal. Thread: any.
void write_message(const Entry& entry, v1::JournalRecord& record);
void write_message(const Missing& missing, v1::JournalRecord& record);

}  // namespace aprsim::server::journal
