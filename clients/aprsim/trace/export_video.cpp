#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>
#include <unistd.h>

#include <fmt/format.h>

#include "clients/aprsim/trace/export_program.hpp"
#include "clients/aprsim/trace/exports.hpp"
#include "clients/aprsim/trace/motion.hpp"

namespace aprsim::trace {
namespace {

namespace fs = std::filesystem;
using client::failed;
using client::FailureKind;

std::string found_in_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string file = (folder.empty() ? "." : folder) + "/" + program;
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0) return file;
  }
  return {};
}

/// JPEG files one after another: the two bytes of a beginning are nowhere else in one.
std::uint64_t count_pictures(const std::string& file) {
  constexpr std::string_view kBegin = "\xff\xd8";
  std::ifstream in(file, std::ios::binary);
  std::array<char, 1 << 16> bytes{};
  std::uint64_t count = 0;
  char last = 0;
  while (in.read(bytes.data(), bytes.size()), in.gcount() > 0) {
    for (const char byte : std::string_view(bytes.data(), static_cast<std::size_t>(in.gcount()))) {
      count += last == kBegin[0] && byte == kBegin[1];
      last = byte;
    }
  }
  return count;
}

}  // namespace

client::Outcome<Exported> export_video(const std::string& place, const VideoChoice& choice,
                                       const std::string& file) {
  const std::string ffmpeg = found_in_path("ffmpeg");
  if (ffmpeg.empty()) {
    return failed(FailureKind::kUsage,
                  "--video needs ffmpeg, which is not in PATH (Debian package: ffmpeg)");
  }
  const auto pictures = Motion::of(place, {.camera = choice.camera,
                                           .rate_hz = choice.rate_hz,
                                           .from_s = choice.from_s,
                                           .to_s = choice.to_s});
  if (!pictures) return tl::unexpected(pictures.error());
  // Samples are whole steps of 1 ms apart.
  const double rate_hz = 1000 / std::max(1.0, std::round(1000 / choice.rate_hz));
  const std::string draft = file + ".draft", log = pictures->file() + ".log";
  // H.264 has an even number of rows and columns here.
  const auto code = run_program({ffmpeg,       "-hide_banner",
                                 "-loglevel",  "error",
                                 "-nostdin",   "-y",
                                 "-f",         "mjpeg",
                                 "-framerate", fmt::format("{:.6f}", rate_hz),
                                 "-i",         pictures->file(),
                                 "-vf",        "crop=trunc(iw/2)*2:trunc(ih/2)*2",
                                 "-c:v",       "libx264",
                                 "-pix_fmt",   "yuv420p",
                                 "-movflags",  "+faststart",
                                 "-f",         "mp4",
                                 draft},
                                log);
  std::error_code problem;
  if (code && *code == 0) {
    fs::rename(draft, file, problem);
    if (!problem) return Exported{.snapshots = count_pictures(pictures->file())};
  }
  std::error_code ignored;
  fs::remove(draft, ignored);
  if (!code) return tl::unexpected(code.error());
  return failed(FailureKind::kUsage,
                problem ? file + ": " + problem.message() : "ffmpeg fails: " + content_of(log));
}

}  // namespace aprsim::trace
