#pragma once

#include "aprsim/v1/control_service.pb.h"
#include "protocols/messages/write_message.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::grpc_server {

/// Writes when a command took effect, from a snapshot.
inline void write_receipt(const api::Snapshot& snapshot, api::Ticket ticket, v1::Receipt& receipt) {
  receipt.set_ticket(ticket);
  receipt.set_epoch(snapshot.epoch);
  receipt.set_step(snapshot.step);
  protocols::write_message(snapshot.time, *receipt.mutable_sim_time());
}

}  // namespace aprsim::grpc_server
