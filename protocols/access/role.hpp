#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace aprsim::protocols {

/// Permission of a caller; each role includes those before it.
enum class Role : std::uint8_t {
  kNone,     ///< query the daemon's health
  kView,     ///< read the state of the cell
  kOperate,  ///< command robots, belt and simulated time, save and load states
  kInject,   ///< inject faults, place an intruder, move bodies, change the scene
  kAdmin     ///< load another scene, delete saved states, start programs
};

inline constexpr std::array<std::string_view, 5> kRoleNames{"none", "view", "operate", "inject",
                                                            "admin"};

[[nodiscard]] constexpr std::string_view to_text(Role role) {
  return kRoleNames[static_cast<std::size_t>(role)];
}

/// Absent = no role has this name.
[[nodiscard]] constexpr std::optional<Role> role_of(std::string_view name) {
  for (std::size_t i = 0; i < kRoleNames.size(); ++i) {
    if (kRoleNames[i] == name) return static_cast<Role>(i);
  }
  return std::nullopt;
}

}  // namespace aprsim::protocols
