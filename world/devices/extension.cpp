#include "world/devices/extension.hpp"

#include <cstdint>
#include <dlfcn.h>
#include <filesystem>
#include <set>

#include "world/scene/model/device.hpp"

namespace aprsim::devices {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "lib", kSuffix = ".so";

tl::unexpected<Error> unusable(const std::string& why) {
  return fail(ErrorCode::kInvalidArgument, "extension", why);
}

/// The loader's latest complaint, without the directory of the library.
std::string loader_complaint(const std::string& directory) {
  const char* text = dlerror();
  std::string out = text ? text : "the loader gives no reason";
  for (auto at = out.find(directory); at != std::string::npos; at = out.find(directory)) {
    out.erase(at, directory.size());
  }
  return out;
}

std::string joined_names(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out.empty() ? "none" : out;
}

/// A function of a library; null = it has none of this name.
template <typename Function>
Function function_of(void* library, const char* name) {
  return reinterpret_cast<Function>(dlsym(library, name));
}

}  // namespace

std::string find_extension(const std::string& name, std::span<const std::string> directories) {
  if (!scene::is_extension_name(name)) return {};
  for (const std::string& directory : directories) {
    std::error_code status;
    const fs::path file =
        fs::absolute(directory, status) / (std::string(kPrefix) + name + std::string(kSuffix));
    if (fs::is_regular_file(file, status)) return file.string();
  }
  return {};
}

std::vector<std::string> extension_names(std::span<const std::string> directories) {
  std::set<std::string> names;  // sorted, each once
  for (const std::string& directory : directories) {
    std::error_code status;
    for (const auto& entry : fs::directory_iterator(directory, status)) {
      const std::string file = entry.path().filename().string();
      if (!file.starts_with(kPrefix) || !file.ends_with(kSuffix)) continue;
      const std::string name =
          file.substr(kPrefix.size(), file.size() - kPrefix.size() - kSuffix.size());
      if (scene::is_extension_name(name)) names.insert(name);
    }
  }
  return {names.begin(), names.end()};
}

Result<Extension> Extension::load(const std::string& name,
                                  std::span<const std::string> directories) {
  const std::string file = find_extension(name, directories);
  if (file.empty()) {
    return fail(ErrorCode::kNotFound, "extension",
                "no lib" + name + ".so in the directories of extensions (option --extensions); " +
                    "extensions there: " + joined_names(extension_names(directories)));
  }
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (library == nullptr) {
    return unusable("lib" + name + ".so cannot be loaded: " +
                    loader_complaint(fs::path(file).parent_path().string() + '/'));
  }
  const auto version = function_of<std::uint32_t (*)()>(library, "aprsim_device_interface");
  const auto make = function_of<Make>(library, "aprsim_make_device");
  if (version == nullptr || make == nullptr) {
    return unusable("lib" + name + ".so is no extension: it lacks APRSIM_EXTENSION(CLASS)");
  }
  if (const std::uint32_t built_for = version(); built_for != device::kInterfaceVersion) {
    return unusable("lib" + name + ".so was built for version " + std::to_string(built_for) +
                    " of the interface of devices, this program has version " +
                    std::to_string(device::kInterfaceVersion) + "; build it again");
  }
  return Extension(make);
}

std::unique_ptr<const device::Device> Extension::make_device(device::Setup& setup) const {
  return std::unique_ptr<const device::Device>(make_(setup));
}

}  // namespace aprsim::devices
