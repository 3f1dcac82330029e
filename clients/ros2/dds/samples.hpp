#pragma once

#include <aprsim_ros2_messages.h>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <google/protobuf/duration.pb.h>

/// Parts of samples as CycloneDDS has them in C.
namespace aprsim::ros2 {

inline builtin_interfaces_msg_dds__Time_ stamp_of(const google::protobuf::Duration& time) {
  return {static_cast<std::int32_t>(time.seconds()), static_cast<std::uint32_t>(time.nanos())};
}

/// A builtin_interfaces/msg/Time or Duration as a protobuf duration.
template <typename Time>
google::protobuf::Duration time_of(const Time& time) {
  google::protobuf::Duration out;
  out.set_seconds(time.sec);
  out.set_nanos(static_cast<std::int32_t>(time.nanosec % 1'000'000'000U));
  return out;
}

/// DDS reads samples only, though its types are not const.
inline char* text_of(const std::string& text) { return const_cast<char*>(text.c_str()); }

/// Lets a sequence refer to values, which stay where they are.
template <typename Sequence, typename Value>
void refer(Sequence& sequence, const std::vector<Value>& values) {
  sequence._buffer = const_cast<Value*>(values.data());
  sequence._length = sequence._maximum = static_cast<std::uint32_t>(values.size());
  sequence._release = false;
}

/// The values of a sequence.
template <typename Sequence>
auto values_of(const Sequence& sequence) {
  return std::span(sequence._buffer, sequence._length);
}

/// The numbers of a sequence.
inline std::vector<double> numbers_of(const dds_sequence_double& sequence) {
  return {sequence._buffer, sequence._buffer + sequence._length};
}

}  // namespace aprsim::ros2
