#pragma once

#include <string>

#include "aprsim/v1/history_service.pb.h"
#include "aprsim/v1/journal.pb.h"
#include "world/api/ports/history.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/api/values/cell_event.hpp"
#include "world/base/result.hpp"

/// Enumerations of the world and their counterparts in messages: both have the same order.
namespace aprsim::protocols {

/// The last enumerators of both. A message's enumeration has an unspecified value before those of
/// the world, or has it for the world's first.
template <auto last, auto message_last>
struct SameOrder {
  using Message = decltype(message_last);
  static constexpr int kLast = static_cast<int>(last);
  static constexpr int kOffset = static_cast<int>(message_last) - kLast;
  static_assert(kOffset == 0 || kOffset == 1, "the enumerations have different lengths");
};

template <typename T>
struct EnumMatch;

/// For a T that is read: kNoun is its name in errors.
template <>
struct EnumMatch<api::StopKind> : SameOrder<api::StopKind::kNormal, v1::StopKind_MAX> {
  static constexpr const char* kNoun = "stop's kind";
};
template <>
struct EnumMatch<api::StreamMode> : SameOrder<api::StreamMode::kMoves, v1::StreamMode_MAX> {
  static constexpr const char* kNoun = "stream's mode";
};
template <>
struct EnumMatch<api::MotionLimit> : SameOrder<api::MotionLimit::kRotAccel, v1::MotionLimit_MAX> {
  static constexpr const char* kNoun = "motion limit";
};
template <>
struct EnumMatch<api::SignalKind> : SameOrder<api::SignalKind::kLightCurtain, v1::GuardSignal_MAX> {
  static constexpr const char* kNoun = "guard's signal";
};
template <>
struct EnumMatch<api::GuardLimit> : SameOrder<api::GuardLimit::kDecreased, v1::GuardLimit_MAX> {
  static constexpr const char* kNoun = "guard's limit";
};
template <>
struct EnumMatch<api::CellEventKind>
    : SameOrder<api::CellEventKind::kRefused, v1::CellEventKind_MAX> {
  static constexpr const char* kNoun = "kinds";
};

template <>
struct EnumMatch<api::RegisterArea>
    : SameOrder<api::RegisterArea::kHoldingRegister, v1::RegisterArea_MAX> {};
template <>
struct EnumMatch<api::RegisterEncoding>
    : SameOrder<api::RegisterEncoding::kFloat32, v1::RegisterEncoding_MAX> {};
template <>
struct EnumMatch<api::WordOrder> : SameOrder<api::WordOrder::kLowFirst, v1::WordOrder_MAX> {};
template <>
struct EnumMatch<api::BodyKind> : SameOrder<api::BodyKind::kPart, v1::BodyKind_MAX> {};
template <>
struct EnumMatch<api::CurtainReaction>
    : SameOrder<api::CurtainReaction::kAll, v1::CurtainReaction_MAX> {};
template <>
struct EnumMatch<api::ActionState> : SameOrder<api::ActionState::kError, v1::ActionState_MAX> {};
template <>
struct EnumMatch<api::ActionKind> : SameOrder<api::ActionKind::kPlanning, v1::ActionKind_MAX> {};
template <>
struct EnumMatch<api::PlanningMode> : SameOrder<api::PlanningMode::kAvoid, v1::PlanningMode_MAX> {
  static constexpr const char* kNoun = "planning mode";
};
template <>
struct EnumMatch<api::MotionSource> : SameOrder<api::MotionSource::kStream, v1::MotionSource_MAX> {
};
template <>
struct EnumMatch<api::StreamPhase> : SameOrder<api::StreamPhase::kStopping, v1::StreamPhase_MAX> {};
template <>
struct EnumMatch<api::StreamResult> : SameOrder<api::StreamResult::kAlarm, v1::StreamResult_MAX> {};
template <>
struct EnumMatch<api::DriveFault> : SameOrder<api::DriveFault::kLightCurtain, v1::DriveFault_MAX> {
};
template <>
struct EnumMatch<api::GroupKind> : SameOrder<api::GroupKind::kDormant, v1::GroupKind_MAX> {};
template <>
struct EnumMatch<api::FaultState> : SameOrder<api::FaultState::kEnded, v1::InjectedFaultState_MAX> {
};
template <>
struct EnumMatch<api::BookmarkKind> : SameOrder<api::BookmarkKind::kStopped, v1::BookmarkKind_MAX> {
};

template <typename T>
[[nodiscard]] typename EnumMatch<T>::Message to_message(T value) {
  return static_cast<typename EnumMatch<T>::Message>(static_cast<int>(value) +
                                                     EnumMatch<T>::kOffset);
}

/// The error for a field that is absent or has a value that this version does not know.
[[nodiscard]] inline tl::unexpected<Error> unknown(const std::string& noun) {
  return fail(ErrorCode::kInvalidArgument, noun,
              "the journal has no " + noun + " that this version knows");
}

/// Errors: kInvalidArgument when `number` is none of the message's enumeration.
template <typename T>
[[nodiscard]] Result<T> from_message(int number) {
  using Match = EnumMatch<T>;
  const int value = number - Match::kOffset;
  if (value >= 0 && value <= Match::kLast) return static_cast<T>(value);
  if constexpr (std::is_same_v<T, api::CellEventKind>) {
    return fail(ErrorCode::kInvalidArgument, Match::kNoun,
                std::to_string(number) + " is not a kind");
  } else {
    return unknown(Match::kNoun);
  }
}

}  // namespace aprsim::protocols
