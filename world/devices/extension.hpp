#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "world/base/result.hpp"
#include "world/devices/interface/device.hpp"

namespace aprsim::devices {

/// A shared library with a class of devices. It stays loaded until the process ends, so that
/// whatever it has made outlives its users. Thread: any.
class Extension {
 public:
  /// Finds libNAME.so in the directories, in their order, and loads it unless it is loaded. Errors:
  /// kNotFound without such a file; kInvalidArgument for a library that cannot be loaded, is no
  /// extension or has another version of the interface.
  [[nodiscard]] static Result<Extension> load(const std::string& name,
                                              std::span<const std::string> directories);

  /// Throws as the device's constructor does.
  [[nodiscard]] std::unique_ptr<const device::Device> make_device(device::Setup& setup) const;

 private:
  using Make = device::Device* (*)(device::Setup&);
  explicit Extension(Make make) : make_(make) {}
  Make make_;
};

/// Path of the library of an extension; empty = it is in none of the directories.
[[nodiscard]] std::string find_extension(const std::string& name,
                                         std::span<const std::string> directories);

/// Names of the extensions in the directories, sorted.
[[nodiscard]] std::vector<std::string> extension_names(std::span<const std::string> directories);

}  // namespace aprsim::devices
