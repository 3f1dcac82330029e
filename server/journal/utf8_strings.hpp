#pragma once

#include <google/protobuf/message.h>

namespace aprsim::server::journal {

/// Writes every byte of the message's strings that is no UTF-8 as "\xNN": proto3 strings that hold
/// other bytes, as file names may, cannot be read again.
void make_utf8(google::protobuf::Message& message);

}  // namespace aprsim::server::journal
