#pragma once

#include <Eigen/Geometry>

#include "aprsim/v1/control_service.pb.h"
#include "aprsim/v1/faults.pb.h"
#include "aprsim/v1/geometry.pb.h"
#include "protocols/messages/field_walk.hpp"
#include "protocols/messages/write_message.hpp"
#include "world/api/commands/command_fields.hpp"
#include "world/base/time.hpp"

/// Codecs of values that have no one-to-one fields in messages.
namespace aprsim::protocols {

template <>
struct Codec<Eigen::Vector3d> {
  static void write(const Eigen::Vector3d& vector, v1::Vector3& message) {
    message.set_x(vector.x());
    message.set_y(vector.y());
    message.set_z(vector.z());
  }
  static Result<void> read(const v1::Vector3& message, Eigen::Vector3d& vector) {
    vector = {message.x(), message.y(), message.z()};
    return {};
  }
};

template <>
struct Codec<Eigen::Quaterniond> {
  static void write(const Eigen::Quaterniond& rotation, v1::Quaternion& message) {
    message.set_w(rotation.w());
    message.set_x(rotation.x());
    message.set_y(rotation.y());
    message.set_z(rotation.z());
  }
  static Result<void> read(const v1::Quaternion& message, Eigen::Quaterniond& rotation) {
    rotation = {message.w(), message.x(), message.y(), message.z()};
    return {};
  }
};

template <>
struct Codec<SimTime> {
  static void write(SimTime span, google::protobuf::Duration& message) {
    message.set_seconds(span.count() / 1'000'000'000);
    message.set_nanos(static_cast<std::int32_t>(span.count() % 1'000'000'000));
  }
  static Result<void> read(const google::protobuf::Duration& message, SimTime& span) {
    span = time_of(message);
    return {};
  }
};

/// Names its quantity.
template <>
struct Codec<api::WhenCrossing> {
  static void write(const api::WhenCrossing& when, v1::CrossingTrigger& message);
  /// Errors: an unknown quantity, or a missing limit.
  static Result<void> read(const v1::CrossingTrigger& message, api::WhenCrossing& when);
};

/// A count of 0 is 1.
template <>
struct Codec<api::WhenGrasped> {
  static Result<void> read(const v1::GraspedTrigger& message, api::WhenGrasped& when);
};

/// 0 steps = the greatest number.
template <>
struct Codec<api::RunUntil> {
  static Result<void> read(const v1::RunUntilRequest& message, api::RunUntil& run);
};

}  // namespace aprsim::protocols
