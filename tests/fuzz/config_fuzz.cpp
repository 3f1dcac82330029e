// The daemon's configuration: first line a setting as of --set, KEY=VALUE (or empty), the rest the
// file. Every accepted value must be within its limits, and be the same after a round trip
// through the output of --print-config.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

#include "server/config/config.hpp"

namespace {

using namespace aprsim;
namespace fs = std::filesystem;

void demand(bool truth) {
  if (!truth) std::abort();
}

/// A file, on a file system in memory where there is one.
class File {
 public:
  explicit File(const std::string& name) {
    const fs::path memory = "/dev/shm";
    const fs::path base = fs::is_directory(memory) ? memory : fs::temp_directory_path();
    path_ = base / ("aprsim-" + name + '-' + std::to_string(::getpid()));
  }
  ~File() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  [[nodiscard]] std::string write(const std::string& text) const {
    std::ofstream(path_, std::ios::binary) << text;
    return path_.string();
  }

 private:
  fs::path path_;
};

using Settings = std::vector<std::pair<std::string, std::string>>;

Settings settings_of(const std::string& line) {
  const std::size_t equals = line.find('=');
  if (equals == std::string::npos) return {};
  return {{line.substr(0, equals), line.substr(equals + 1)}};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const File input("config-fuzz"), again("config-fuzz-again");
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::size_t end = text.find('\n');
  const std::string first = text.substr(0, end);
  const std::string file = input.write(end == std::string::npos ? "" : text.substr(end + 1));
  const auto config = server::load_config(file, settings_of(first));
  if (!config) {
    demand(!config.error().message.empty());
    return 0;
  }
  demand(config->modbus.max_connections >= 1 && config->modbus.full_scale_m_s > 0);
  demand(config->vision.repeat_s >= 0.01 && config->vision.repeat_s <= 0.5);
  const std::string shown = server::to_yaml(*config);
  const auto reread = server::load_config(again.write(shown), {});
  demand(reread.has_value());
  demand(server::to_yaml(*reread) == shown);
  return 0;
}
