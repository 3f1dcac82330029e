#include "server/ports_file.hpp"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

namespace aprsim::server {
namespace {

tl::unexpected<Error> refuse(const std::string& path, const std::string& cause) {
  return fail(ErrorCode::kUnavailable, "ports-file", "cannot write " + path + ": " + cause);
}

/// The process that has written the file; 0 = none that can be told.
pid_t writer_of(const std::string& path) {
  std::ifstream in(path);
  const auto json = nlohmann::json::parse(in, nullptr, false);
  if (!json.is_object() || !json.contains("pid") || !json["pid"].is_number_integer()) return 0;
  const auto pid = json["pid"].get<std::int64_t>();
  return pid > 0 && pid < (1 << 30) ? static_cast<pid_t>(pid) : 0;
}

/// Whether the process lives and is a daemon like this one.
bool is_daemon(pid_t pid) {
  const auto name = [](const std::string& process) {
    std::string text;
    std::getline(std::ifstream("/proc/" + process + "/comm"), text);
    return text;
  };
  return pid > 0 && ::kill(pid, 0) == 0 && name(std::to_string(pid)) == name("self");
}

/// A new file of its own, whatever stands there under the name.
Result<void> write_new(const std::string& path, const std::string& text) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (file < 0) return refuse(path, std::strerror(errno));
  const ssize_t written = ::write(file, text.data(), text.size());
  const int error = written < 0 ? errno : ENOSPC;
  const bool closed = ::close(file) == 0;
  if (closed && written == static_cast<ssize_t>(text.size())) return {};
  ::unlink(path.c_str());
  return refuse(path, std::strerror(error));
}

}  // namespace

Result<void> PortsFile::write(const std::string& path, const Ports& ports) {
  struct stat there {};
  if (::lstat(path.c_str(), &there) == 0) {
    if (!S_ISREG(there.st_mode)) return refuse(path, "it is not a regular file");
    const pid_t writer = writer_of(path);
    if (writer != ::getpid() && is_daemon(writer)) {
      return refuse(path,
                    "it belongs to the daemon that runs as process " + std::to_string(writer));
    }
  }
  nlohmann::json json;
  for (const auto& [name, port] : ports) json[name] = port;
  json["pid"] = ::getpid();
  const std::string draft = path + "." + std::to_string(::getpid()) + ".tmp";
  ::unlink(draft.c_str());
  if (auto ok = write_new(draft, json.dump(2) + "\n"); !ok) return ok;
  if (std::rename(draft.c_str(), path.c_str()) != 0) {
    const std::string cause = std::strerror(errno);
    ::unlink(draft.c_str());
    return refuse(path, cause);
  }
  path_ = path;
  return {};
}

PortsFile::~PortsFile() {
  if (!path_.empty() && writer_of(path_) == ::getpid()) ::unlink(path_.c_str());
}

}  // namespace aprsim::server
