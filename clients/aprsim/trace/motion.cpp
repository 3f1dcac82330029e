#include "clients/aprsim/trace/motion.hpp"

#include <cstdlib>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "clients/aprsim/trace/export_program.hpp"
#include "proto/journal/journal_place.hpp"
#include "world/base/process/own_programs.hpp"

namespace aprsim::trace {
namespace {

namespace fs = std::filesystem;
using client::failed;
using client::FailureKind;
}  // namespace

client::Outcome<Motion> Motion::of(const std::string& place, const Choice& choice) {
  const auto files = aprsim::journal::files_of_run(place);
  if (!files) return failed(FailureKind::kUsage, files.error().message);
  Motion out;
  std::error_code status;
  std::string name = (fs::temp_directory_path(status) / "aprsim-motion-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    return failed(FailureKind::kUsage, "cannot create a directory like " + name);
  }
  out.directory_ = name;
  out.file_ = name + "/motion";
  std::vector<std::string> arguments{process::program_beside("aprsimd"),
                                     choice.camera.empty() ? "--motion" : "--video", out.file_,
                                     "--motion-rate", fmt::format("{:g}", choice.rate_hz)};
  if (!choice.camera.empty()) arguments.insert(arguments.end(), {"--camera", choice.camera});
  if (choice.from_s) {
    arguments.insert(arguments.end(), {"--motion-from", fmt::format("{:.6f}", *choice.from_s)});
  }
  if (choice.to_s) {
    arguments.insert(arguments.end(), {"--motion-to", fmt::format("{:.6f}", *choice.to_s)});
  }
  arguments.emplace_back("--replay");
  arguments.insert(arguments.end(), files->begin(), files->end());
  const std::string log = name + "/log";
  const auto code = run_program(arguments, log);
  if (!code) return tl::unexpected(code.error());
  out.said_ = content_of(log);
  // A replay that differs has motion up to the difference.
  if (*code != 0 && *code != 1) {
    return failed(FailureKind::kUsage, place + " cannot be run again: " + out.said_);
  }
  return out;
}

Motion::Motion(Motion&& other) noexcept
    : directory_(std::exchange(other.directory_, {})),
      file_(std::move(other.file_)),
      said_(std::move(other.said_)) {}

Motion::~Motion() {
  std::error_code ignored;
  if (!directory_.empty()) fs::remove_all(directory_, ignored);
}

}  // namespace aprsim::trace
