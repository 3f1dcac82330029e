#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace aprsim::scene {

/// A parameter of a device as the scene's file has it: the extension decides how it is read.
struct DeviceParameter {
  std::string name;
  std::vector<std::string> values;  ///< scalars; one unless it is a list
  bool is_list = false;
  std::string place;  ///< LINE:COLUMN: KEY
};

/// A device that an extension makes: see world/devices.
struct Device {
  std::string name;
  std::string extension;  ///< name of its library, never a path
  std::string place;      ///< LINE:COLUMN: KEY of `extension`
  std::vector<DeviceParameter> parameters;
};

inline constexpr std::size_t kMaxDevices = 64;
inline constexpr std::size_t kMaxDeviceParameters = 256;

/// Whether it can be the name of an extension: 1 to 64 letters, digits, '_' and '-'.
[[nodiscard]] inline bool is_extension_name(std::string_view name) {
  constexpr std::string_view kCharacters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  return !name.empty() && name.size() <= 64 &&
         name.find_first_not_of(kCharacters) == std::string_view::npos;
}

}  // namespace aprsim::scene
