#include "server/ports_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <unistd.h>

#include <nlohmann/json.hpp>

namespace aprsim::server {

Result<void> write_ports_file(const std::string& path, const Ports& ports) {
  nlohmann::json json;
  for (const auto& [name, port] : ports) json[name] = port;
  json["pid"] = ::getpid();
  const std::string draft = path + "." + std::to_string(::getpid()) + ".tmp";
  {
    std::ofstream out(draft);
    out << json.dump(2) << "\n";
    out.flush();
    if (!out) return fail(ErrorCode::kUnavailable, "ports-file", "cannot write " + draft);
  }
  if (std::rename(draft.c_str(), path.c_str()) != 0) {
    const std::string cause = std::strerror(errno);
    std::remove(draft.c_str());
    return fail(ErrorCode::kUnavailable, "ports-file", "cannot write " + path + ": " + cause);
  }
  return {};
}

}  // namespace aprsim::server
