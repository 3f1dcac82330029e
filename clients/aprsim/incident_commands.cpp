#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cell_connection.hpp"
#include "clients/aprsim/commands.hpp"

namespace aprsim::client {
namespace {

/// A name without folders, whatever a daemon says.
std::string plain_name(const std::string& name) {
  const std::string plain = std::filesystem::path(name).filename().string();
  return plain.empty() || plain == "." || plain == ".." ? "incident.journal" : plain;
}

}  // namespace

Outcome<void> run_command(const IncidentCommand& command, Console& console) {
  std::string name = command.file;
  std::ofstream file;
  std::uint64_t bytes = 0, expected = 0;
  int error = 0;
  const auto write = [&](const v1::GetIncidentResponse& piece) {
    if (!file.is_open()) {
      if (name.empty()) name = plain_name(piece.name());
      expected = piece.size();
      errno = 0;
      file.open(name, std::ios::binary | std::ios::trunc);
    }
    file.write(piece.data().data(), static_cast<std::streamsize>(piece.data().size()));
    bytes += piece.data().size();
    if (!file) error = errno != 0 ? errno : EIO;
    return error == 0;
  };
  const auto done = CellConnection(console.endpoints).incident(command.last_s, write);
  if (!done) return tl::unexpected(done.error());
  errno = 0;
  if (error == 0 && !file.flush()) error = errno != 0 ? errno : EIO;
  if (error != 0) {
    return tl::unexpected(
        Failure{FailureKind::kUsage, fmt::format("{}: {}", name, std::strerror(error))});
  }
  if (bytes != expected) {
    return tl::unexpected(Failure{FailureKind::kConnection,
                                  fmt::format("{}: {} of {} bytes came", name, bytes, expected)});
  }
  console.show(fmt::format("{}: {:.1f} MB\n", name, static_cast<double>(bytes) * 1e-6),
               {{"done", "incident"}, {"file", name}, {"bytes", bytes}});
  return {};
}

}  // namespace aprsim::client
