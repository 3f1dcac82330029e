#pragma once

#include <bitset>
#include <chrono>
#include <string>
#include <vector>

#include "aprsim/v1/control_service.pb.h"
#include "aprsim/v1/events.pb.h"
#include "aprsim/v1/snapshot.pb.h"
#include "world/api/faults/fault_kinds.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/api/values/cell_event.hpp"

/// The world's values as messages of aprsim.v1. Field for field; units are SI on both sides.
namespace aprsim::protocols {

void write_message(const Eigen::Vector3d& vector, v1::Vector3& message);
void write_message(const Pose& pose, v1::Pose& message);
void write_message(std::chrono::nanoseconds span, google::protobuf::Duration& message);
void write_message(const api::CellDescription& cell, v1::CellDescription& message);
void write_message(const api::CameraDescription& camera, v1::CameraDescription& message);
void write_message(const api::BodySnapshot& body, const api::BodyDescription& description,
                   v1::BodyState& message);
void write_message(const api::ConveyorSnapshot& conveyor,
                   const api::ConveyorDescription& description, v1::ConveyorState& message);

void write_message(const api::LightCurtainSnapshot& curtain,
                   const api::LightCurtainDescription& description, v1::LightCurtainState& message);

/// Fails for an invalid one.
[[nodiscard]] Result<std::vector<api::CellEventKind>> event_kinds(
    const google::protobuf::RepeatedField<int>& kinds);
/// The message must be empty.
void write_message(const api::CellEvent& event, v1::CellEvent& message);
/// Values beyond all limits are kept.
[[nodiscard]] SimTime time_of(const google::protobuf::Duration& span);
void write_message(const api::StreamEnd& end, v1::StreamEnd& message);
void write_message(const api::InjectedFault& fault, v1::InjectedFault& message);
void write_message(const faults::KindInfo& kind, v1::FaultKind& message);
/// All kinds and quantities. The message must be empty.
void write_fault_kinds(v1::ListFaultKindsResponse& message);

/// The parts of a snapshot to write; by default all.
struct SnapshotParts {
  /// The expensive fields to leave out, by field number of v1::Snapshot.
  std::bitset<128> without;
  /// The robots, bodies and tools to write, by index; null = all. Contacts are those of the written
  /// bodies and robots.
  struct Entities {
    std::vector<bool> robots, bodies, tools;
  };
  const Entities* entities = nullptr;
};

/// The message must be empty. sample_time is taken from the wall clock here.
void write_message(const api::Snapshot& snapshot, const std::string& instance_id,
                   v1::Snapshot& message, const SnapshotParts& parts = {});

}  // namespace aprsim::protocols
