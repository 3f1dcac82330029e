#include "server/programs/cell_programs.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "server/access/exposure.hpp"

namespace aprsim::server {
namespace {

/// A new private directory; empty where it cannot be created.
std::string make_directory() {
  std::error_code failed;
  std::string name = (std::filesystem::temp_directory_path(failed) / "aprsimd-XXXXXX").string();
  if (!failed && mkdtemp(name.data()) == nullptr) failed = {errno, std::generic_category()};
  if (!failed) return name;
  spdlog::warn("programs: no directory for their ports file: {}", failed.message());
  return {};
}

/// Whether a listener at that address is reached at a numeric host of this machine.
bool reaches(const std::string& address, const std::string& host) {
  if (address == host || address == "::") return true;
  if (address == "localhost") return host == "127.0.0.1" || host == "::1";
  return address == "0.0.0.0" && host.find(':') == std::string::npos;
}

/// The address at which programs on this machine reach all listeners; empty where they have
/// several.
std::optional<std::string> host_of(const Config& config) {
  const std::array all{config.crcl.address, config.modbus.address, config.vision.address,
                       config.grpc.address};
  std::vector<std::string> hosts{"127.0.0.1", "::1"};
  hosts.insert(hosts.end(), all.begin(), all.end());
  for (const std::string& host : hosts) {
    if (host == "0.0.0.0" || host == "::" || host == "localhost") continue;
    if (std::ranges::all_of(all, [&](const std::string& a) { return reaches(a, host); })) {
      return host;
    }
  }
  return std::nullopt;
}

}  // namespace

CellPrograms::CellPrograms(const Config& config, bool demo, std::string token) : demo_(demo) {
  const bool pages_may = may_start_programs(config);
  if (!pages_may && !demo) return;
  directory_ = make_directory();
  if (directory_.empty()) return;
  ProgramsOptions options;
  host_ = host_of(config);
  if (host_) {
    options.programs = programs_of(config.scene);
    options.scenario_command = scenario_command(*host_, ports_path());
    options.directory = directory_;
  } else {
    options.refusal = "Listeners have different addresses, and programs know one.";
  }
  if (!pages_may) options.refusal = "Pages start and stop no programs here (web.programs).";
  options.environment["APRSIM_TOKEN"] = std::move(token);
  // Programs trust the daemon's own certificate, which must name the address that they use.
  if (config.tls.certificate) options.environment["APRSIM_CA"] = *config.tls.certificate;
  programs_ = std::make_unique<Programs>(std::move(options));
}

CellPrograms::~CellPrograms() { end(); }

Result<void> CellPrograms::begin(const Ports& ports) {
  if (programs_) {
    ports_file_ = std::make_unique<PortsFile>();
    if (auto written = ports_file_->write(ports_path(), ports); !written) return written;
  }
  if (!demo_) return {};
  if (!programs_) {
    return fail(ErrorCode::kUnavailable, "demo", "--demo: no directory for a ports file");
  }
  auto launched = programs_->launch(kDemo, {});
  if (!launched && launched.error().code == ErrorCode::kNotFound) {
    return fail(ErrorCode::kNotFound, "demo",
                "--demo: the kitting controller does not know this cell: a scene of "
                "clients/kitting/cells is expected, at one address");
  }
  return launched;
}

void CellPrograms::update(const Ports& ports) {
  if (!ports_file_ || ports == written_) return;
  written_ = ports;
  if (auto written = ports_file_->write(ports_path(), ports); !written) {
    spdlog::error("programs: {}", written.error().message);
  }
}

std::vector<Program> CellPrograms::programs_of(const std::string& scene) const {
  if (!host_) return {};
  return known_programs(scene, *host_, ports_path());
}

void CellPrograms::offer(std::vector<Program> programs) {
  if (programs_ && host_) programs_->offer(std::move(programs));
}

void CellPrograms::close() {
  if (programs_) programs_->close();
}

void CellPrograms::end() {
  programs_.reset();
  ports_file_.reset();
  std::error_code ignored;
  if (!directory_.empty()) std::filesystem::remove(directory_, ignored);
  directory_.clear();
}

}  // namespace aprsim::server
