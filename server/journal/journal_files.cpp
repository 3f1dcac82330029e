#include "server/journal/journal_files.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "proto/journal/frames.hpp"

namespace aprsim::server::journal {

JournalFiles::JournalFiles(std::string place, std::string stamp, std::uint64_t max_bytes)
    : place_(std::move(place)), stamp_(std::move(stamp)), max_bytes_(max_bytes) {}

JournalFiles::~JournalFiles() { close(); }

std::string JournalFiles::name_of(std::uint32_t part) const {
  std::error_code none;
  if (std::filesystem::is_directory(place_, none)) {
    return (std::filesystem::path(place_) /
            ("aprsim-" + stamp_ + "-" + std::to_string(part) + ".journal"))
        .string();
  }
  return part == 1 ? place_ : place_ + "." + std::to_string(part);
}

tl::unexpected<Error> JournalFiles::failed(const char* what, int error) const {
  return fail(ErrorCode::kUnavailable, "journal",
              file_ + ": " + what + ": " + std::strerror(error));
}

Result<void> JournalFiles::open_next(const std::string& frame) {
  close();
  file_ = name_of(part_ + 1);
  descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor_ < 0) return failed("cannot be opened", errno);
  size_ = 0;
  auto written = append(std::string(aprsim::journal::kMagic) + frame);
  if (!written) {
    close();
    return written;
  }
  ++part_;
  return {};
}

Result<void> JournalFiles::append(const std::string& frame) {
  std::size_t done = 0;
  while (done < frame.size()) {
    const ssize_t wrote = ::write(descriptor_, frame.data() + done, frame.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) {
      const int error = wrote == 0 ? ENOSPC : errno;
      // Of what is no regular file nothing can be taken back.
      if (::ftruncate(descriptor_, static_cast<off_t>(size_)) == 0) {
        ::lseek(descriptor_, static_cast<off_t>(size_), SEEK_SET);
      }
      return failed("cannot be written", error);
    }
    done += static_cast<std::size_t>(wrote);
  }
  size_ += frame.size();
  return {};
}

void JournalFiles::close() {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

}  // namespace aprsim::server::journal
