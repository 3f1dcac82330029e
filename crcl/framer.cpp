#include "crcl/framer.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::crcl {
namespace {

constexpr std::string_view kSeparators("\0 \t\r\n", 5);
constexpr std::string_view kSpace = " \t\r\n";

}  // namespace

Framer::Framer(std::string_view root, std::size_t max_bytes)
    : end_tag_("</" + std::string(root)), max_bytes_(max_bytes) {}

Framer Framer::for_commands(std::size_t max_bytes) { return {"CRCLCommandInstance", max_bytes}; }
Framer Framer::for_statuses(std::size_t max_bytes) { return {"CRCLStatus", max_bytes}; }

void Framer::append(std::string_view bytes) { buffer_ += bytes; }

void Framer::skip_separators() {
  start_ = std::min(buffer_.find_first_not_of(kSeparators, start_), buffer_.size());
  scanned_ = std::max(scanned_, start_);
}

std::size_t Framer::find_end() {
  while (true) {
    const std::size_t tag = buffer_.find(end_tag_, scanned_);
    if (tag == std::string::npos) {
      // The tag may have begun in the last bytes.
      const std::size_t keep = end_tag_.size() - 1;
      scanned_ = std::max(scanned_, buffer_.size() > keep ? buffer_.size() - keep : 0);
      return std::string::npos;
    }
    scanned_ = tag;
    const std::size_t close = buffer_.find_first_not_of(kSpace, tag + end_tag_.size());
    if (close == std::string::npos) return std::string::npos;
    if (buffer_[close] == '>') return close + 1;
    scanned_ = tag + 1;
  }
}

Result<std::optional<std::string>> Framer::next() {
  skip_separators();
  const std::size_t end = find_end();
  const bool complete = end != std::string::npos;
  if ((complete ? end : buffer_.size()) - start_ > max_bytes_) {
    Error error;
    error.kind = ErrorKind::kTooLarge;
    error.expected = "expected a document of at most " + std::to_string(max_bytes_) +
                     " bytes that ends with " + end_tag_ + ">";
    return tl::unexpected<Error>(std::move(error));
  }
  if (!complete) {
    discard_consumed();
    return std::nullopt;
  }
  std::string document = buffer_.substr(start_, end - start_);
  start_ = scanned_ = end;
  return document;
}

// Only when nothing complete is left, so that many documents in one read cost one move.
void Framer::discard_consumed() {
  if (start_ == 0) return;
  buffer_.erase(0, start_);
  scanned_ -= start_;
  start_ = 0;
}

}  // namespace aprsim::crcl
