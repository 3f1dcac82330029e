#include "world/base/files/draft_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/stat.h>
#include <unistd.h>

namespace aprsim::files {
namespace {

namespace fs = std::filesystem;

/// A file that a rename may replace, or none yet.
bool is_replaceable(const std::string& place) {
  std::error_code none;
  const fs::file_status status = fs::status(place, none);
  const std::string absolute = fs::absolute(place, none).lexically_normal().string();
  // Names of open files: a rename would take the name and leave the open file as it is.
  if (absolute.starts_with("/dev/") || absolute.starts_with("/proc/")) return false;
  return fs::is_regular_file(status) || status.type() == fs::file_type::not_found;
}

/// The place that a chain of symbolic links names, which need not exist.
std::string resolved(const std::string& place) {
  std::error_code failed;
  if (!fs::is_symlink(place, failed)) return place;
  const fs::path target = fs::weakly_canonical(place, failed);
  return failed ? place : target.string();
}

}  // namespace

DraftFile::DraftFile(const std::string& place) : place_(place), target_(resolved(place)) {
  if (is_replaceable(target_)) draft_ = target_ + '.' + std::to_string(::getpid()) + ".part";
  open();
}

DraftFile::~DraftFile() {
  if (!draft_.empty()) ::unlink(draft_.c_str());
}

void DraftFile::open() {
  errno = 0;
  if (draft_.empty()) {
    out_.open(target_, std::ios::binary | std::ios::trunc);
  } else {
    ::unlink(draft_.c_str());
    struct stat there {};
    const bool exists = ::stat(target_.c_str(), &there) == 0;
    errno = 0;
    const int file =
        ::open(draft_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file < 0) {
      error_ = errno;
      draft_.clear();
      out_.setstate(std::ios::failbit);
      return;
    }
    // The rights of the file that it replaces.
    if (exists) static_cast<void>(::fchmod(file, there.st_mode & 0777));
    ::close(file);
    out_.open(draft_, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
  }
  if (!out_) error_ = errno != 0 ? errno : EIO;
}

Result<void> DraftFile::commit() {
  if (error_ == 0) {
    errno = 0;
    if (out_.flush()) out_.close();
    if (!out_) error_ = errno != 0 ? errno : EIO;
  }
  if (error_ == 0 && !draft_.empty()) {
    if (std::rename(draft_.c_str(), target_.c_str()) == 0) {
      draft_.clear();
    } else {
      error_ = errno;
    }
  }
  if (error_ == 0) return {};
  return fail(ErrorCode::kUnavailable, "file",
              place_ + " cannot be written: " + std::strerror(error_));
}

Result<void> check_outputs(std::span<const std::string> inputs,
                           std::span<const std::string> outputs) {
  std::error_code none;
  const auto refuse = [](const std::string& output, const std::string& other, const char* what) {
    return fail(
        ErrorCode::kInvalidArgument, "output",
        output + " is the same file as the " + what + ' ' + other + "; nothing was written");
  };
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const fs::path output = outputs[i];
    // A device can be read and written at once.
    if (fs::exists(output, none) && !fs::is_regular_file(output, none)) continue;
    for (const std::string& input : inputs) {
      if (fs::equivalent(input, output, none)) return refuse(outputs[i], input, "input");
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (fs::weakly_canonical(outputs[k], none) == fs::weakly_canonical(output, none) ||
          fs::equivalent(outputs[k], output, none)) {
        return refuse(outputs[i], outputs[k], "output");
      }
    }
  }
  return {};
}

}  // namespace aprsim::files
