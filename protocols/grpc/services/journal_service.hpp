#pragma once

#include <atomic>

#include "aprsim/v1/journal_service.grpc.pb.h"
#include "protocols/grpc/calls/call_gate.hpp"
#include "protocols/ports/incident_source.hpp"

namespace aprsim::grpc_server {

/// aprsim.v1.JournalService on the callback API. Never waits.
class JournalService final : public v1::JournalService::CallbackService {
 public:
  /// `incidents` may be null; both outlive the service.
  JournalService(protocols::IncidentSource* incidents, const CallGate& gate)
      : incidents_(incidents), gate_(gate) {}

  grpc::ServerWriteReactor<v1::GetIncidentResponse>* GetIncident(
      grpc::CallbackServerContext* context, const v1::GetIncidentRequest* request) override;

 private:
  protocols::IncidentSource* const incidents_;
  const CallGate& gate_;
  std::atomic<int> open_{0};  ///< calls that hold an incident
};

}  // namespace aprsim::grpc_server
