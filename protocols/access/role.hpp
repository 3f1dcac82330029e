#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace aprsim::protocols {

/// Permission of a caller; each role includes those before it.
enum class Role : std::uint8_t {
  kNone,     ///< ask whether the daemon is there
  kView,     ///< look at the cell
  kOperate,  ///< command robots, belt and simulated time, save and load states
  kInject,   ///< do what the cell itself would never: faults, an intruder, things moved by hand
  kAdmin     ///< build the cell anew, delete what others have saved, start programs
};

inline constexpr std::array<std::string_view, 5> kRoleNames{"none", "view", "operate", "inject",
                                                            "admin"};

[[nodiscard]] constexpr std::string_view to_text(Role role) {
  return kRoleNames[static_cast<std::size_t>(role)];
}

/// Absent = no role is called so.
[[nodiscard]] constexpr std::optional<Role> role_of(std::string_view name) {
  for (std::size_t i = 0; i < kRoleNames.size(); ++i) {
    if (kRoleNames[i] == name) return static_cast<Role>(i);
  }
  return std::nullopt;
}

}  // namespace aprsim::protocols
