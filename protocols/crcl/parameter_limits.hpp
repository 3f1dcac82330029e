#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "crcl/values.hpp"
#include "world/base/result.hpp"

/// Bounds of what one robot keeps for its clients under names that they choose, and tells all of
/// them in every status.
namespace aprsim::crcl_server {

inline constexpr std::size_t kMaxParameters = 256;
inline constexpr std::size_t kMaxNameBytes = 128, kMaxValueBytes = 1024;
inline constexpr std::size_t kMaxKeptBytes = 65'536;  ///< of names and values of one kind

/// Refuses a setting whose name is empty or too long, or whose value is too long.
[[nodiscard]] inline Result<void> check_size(const crcl::ParameterSetting& setting) {
  if (setting.name.empty() || setting.name.size() > kMaxNameBytes) {
    return fail(ErrorCode::kInvalidArgument, "ParameterName",
                setting.name.empty()
                    ? "ParameterName is empty"
                    : fmt::format("ParameterName has {} bytes, must have at most {}",
                                  setting.name.size(), kMaxNameBytes));
  }
  if (setting.value.size() <= kMaxValueBytes) return {};
  return fail(ErrorCode::kInvalidArgument, setting.name,
              fmt::format("the value of {} has {} bytes, must have at most {}", setting.name,
                          setting.value.size(), kMaxValueBytes));
}

/// The same for a thing under a name with options: of the options together.
[[nodiscard]] inline Result<void> check_size(const char* element, const std::string& name,
                                             const std::vector<crcl::ParameterSetting>& options) {
  std::size_t bytes = 0;
  for (const crcl::ParameterSetting& option : options) {
    bytes += option.name.size() + option.value.size();
  }
  if (name.size() > kMaxNameBytes || bytes > kMaxValueBytes) {
    return fail(ErrorCode::kInvalidArgument, element,
                fmt::format("{} has {} bytes and its options {}, must have at most {} and {}",
                            element, name.size(), bytes, kMaxNameBytes, kMaxValueBytes));
  }
  return {};
}

}  // namespace aprsim::crcl_server
