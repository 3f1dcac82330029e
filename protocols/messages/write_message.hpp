#pragma once

#include <chrono>
#include <string>

#include "aprsim/v1/control_service.pb.h"
#include "aprsim/v1/snapshot.pb.h"
#include "world/api/snapshot.hpp"
#include "world/fault_kinds/fault_kinds.hpp"

/// The world's values as messages of aprsim.v1. Field for field; units are SI on both sides.
namespace aprsim::protocols {

[[nodiscard]] v1::BodyKind body_kind(api::BodyKind kind);

void write_message(const Eigen::Vector3d& vector, v1::Vector3& message);
void write_message(const Pose& pose, v1::Pose& message);
void write_message(std::chrono::nanoseconds span, google::protobuf::Duration& message);
void write_message(const api::CellDescription& cell, v1::CellDescription& message);
void write_message(const api::ConveyorSnapshot& conveyor,
                   const api::ConveyorDescription& description, v1::ConveyorState& message);

void write_message(const api::LightCurtainSnapshot& curtain,
                   const api::LightCurtainDescription& description, v1::LightCurtainState& message);

void write_message(const api::InjectedFault& fault, v1::InjectedFault& message);
void write_message(const faults::KindInfo& kind, v1::FaultKind& message);
void write_message(const faults::QuantityInfo& quantity, v1::FaultQuantity& message);
/// All kinds and quantities. The message must be empty.
void write_fault_kinds(v1::ListFaultKindsResponse& message);

/// The message must be empty. sample_time is taken from the wall clock here.
void write_message(const api::Snapshot& snapshot, const std::string& instance_id,
                   v1::Snapshot& message);

}  // namespace aprsim::protocols
