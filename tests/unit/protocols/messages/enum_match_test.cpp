// Enumerations of the world and of messages have the same names in the same order.

#include "protocols/messages/enum_match.hpp"

#include <cctype>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include <google/protobuf/generated_enum_reflection.h>
#include <gtest/gtest.h>

namespace aprsim::protocols {
namespace {

/// "PROTECTIVE_STOP" of CellEventKind::kProtectiveStop.
template <auto value>
std::string name_of() {
  const std::string_view function = __PRETTY_FUNCTION__;
  std::string name;
  for (std::size_t i = function.rfind("::k") + 3; std::isalnum(function[i]) != 0; ++i) {
    if (std::isupper(function[i]) != 0 && !name.empty()) name += '_';
    name += static_cast<char>(std::toupper(function[i]));
  }
  return name;
}

/// Those that messages say at more length.
const std::map<std::string, std::string> kLonger = {{"INIT", "INITIALIZE"},
                                                    {"FORCE_R", "FORCE_IN_ROBOT"},
                                                    {"TORQUE_R", "TORQUE_IN_ROBOT"},
                                                    {"FORCE_T", "FORCE_IN_TOOL"},
                                                    {"TORQUE_T", "TORQUE_IN_TOOL"}};

template <typename T, int value>
void expect_name() {
  std::string name = name_of<static_cast<T>(value)>();
  const auto longer = kLonger.find(name);
  if (longer != kLonger.end()) name = longer->second;
  const int number = value + EnumMatch<T>::kOffset;
  using Message = typename EnumMatch<T>::Message;
  const auto* descriptor =
      google::protobuf::GetEnumDescriptor<Message>()->FindValueByNumber(number);
  ASSERT_NE(descriptor, nullptr);
  const std::string& message_name = descriptor->name();
  // The first of the world's may be what a message leaves unspecified.
  if (number > 0) {
    EXPECT_TRUE(message_name.ends_with("_" + name)) << message_name << " is " << name;
  }
}

template <typename T>
void expect_names() {
  []<int... values>(std::integer_sequence<int, values...>) { (expect_name<T, values>(), ...); }
  (std::make_integer_sequence<int, EnumMatch<T>::kLast + 1>());
}

TEST(EnumMatch, HasTheSameNamesInOrder) {
  expect_names<api::StopKind>();
  expect_names<api::MotionLimit>();
  expect_names<api::SignalKind>();
  expect_names<api::GuardLimit>();
  expect_names<api::CellEventKind>();
  expect_names<api::BodyKind>();
  expect_names<api::CurtainReaction>();
  expect_names<api::ActionState>();
  expect_names<api::ActionKind>();
  expect_names<api::DriveFault>();
  expect_names<api::GroupKind>();
  expect_names<api::FaultState>();
  expect_names<api::BookmarkKind>();
}

}  // namespace
}  // namespace aprsim::protocols
