#include "crcl/framer.hpp"

#include <algorithm>
#include <utility>

#include "crcl/text.hpp"

namespace aprsim::crcl {
namespace {

constexpr std::string_view kSeparators("\0 \t\r\n", 5);

}  // namespace

Framer::Framer(std::vector<Root> roots) {
  for (Root& root : roots) {
    kinds_.push_back({"<" + root.name, "</" + root.name, root.max_bytes});
    longest_ = std::max(longest_, kinds_.back().end_tag.size());
    widest_ = std::max(widest_, root.max_bytes);
  }
}

Framer Framer::for_commands(std::size_t max_bytes, std::size_t max_program_bytes) {
  std::vector<Root> roots{{"CRCLCommandInstance", max_bytes}};
  if (max_program_bytes > 0) roots.push_back({"CRCLProgram", max_program_bytes});
  return Framer(std::move(roots));
}

Framer Framer::for_statuses(std::size_t max_bytes) { return Framer({{"CRCLStatus", max_bytes}}); }

void Framer::append(std::string_view bytes) { buffer_ += bytes; }

void Framer::skip_separators() {
  start_ = std::min(buffer_.find_first_not_of(kSeparators, start_), buffer_.size());
  scanned_ = std::max(scanned_, start_);
  rooted_ = std::max(rooted_, start_);
}

// Which kind of document this is decides where it ends: a command may carry a program as text.
void Framer::find_root() {
  if (root_ || kinds_.size() == 1) {
    root_ = root_.value_or(0);
    return;
  }
  std::size_t first = std::string::npos;
  const auto offer = [&](std::size_t kind, const std::string& tag) {
    const std::size_t at = buffer_.find(tag, rooted_);
    if (at >= first) return;
    first = at;
    root_ = kind;
  };
  for (std::size_t i = 0; i < kinds_.size(); ++i) offer(i, kinds_[i].start_tag);
  offer(0, kinds_[0].end_tag);  // an end without a start ends what stands before it
  if (root_) scanned_ = first;  // what stands before is no end of this one
  if (!root_ && buffer_.size() > longest_) {
    rooted_ = std::max(rooted_, buffer_.size() - longest_);
  }
}

std::size_t Framer::find_end() {
  const std::string& end_tag = kinds_[root_.value_or(0)].end_tag;
  while (true) {
    const std::size_t tag = buffer_.find(end_tag, scanned_);
    if (tag == std::string::npos) {
      // The tag may have begun in the last bytes.
      const std::size_t keep = longest_ - 1;
      scanned_ = std::max(scanned_, buffer_.size() > keep ? buffer_.size() - keep : 0);
      return std::string::npos;
    }
    scanned_ = tag;
    const std::size_t close =
        buffer_.find_first_not_of(kXmlSpace, std::max(tag + end_tag.size(), blank_until_));
    if (close == std::string::npos) {
      blank_until_ = buffer_.size();
      return std::string::npos;
    }
    if (buffer_[close] == '>') return close + 1;
    scanned_ = tag + 1;
  }
}

Result<std::optional<std::string>> Framer::next() {
  skip_separators();
  find_root();
  const std::size_t end = find_end();
  const bool complete = end != std::string::npos;
  const Kind& kind = kinds_[root_.value_or(0)];
  // What has not begun may still become the longest kind.
  const std::size_t limit = root_ ? kind.max_bytes : widest_;
  if ((complete ? end : buffer_.size()) - start_ > limit) {
    Error error;
    error.kind = ErrorKind::kTooLarge;
    error.expected = "expected a document of at most " + std::to_string(limit) +
                     " bytes that ends with " + kind.end_tag + ">";
    return tl::unexpected<Error>(std::move(error));
  }
  if (!complete) {
    discard_consumed();
    return std::nullopt;
  }
  std::string document = buffer_.substr(start_, end - start_);
  last_ = root_.value_or(0);
  start_ = scanned_ = rooted_ = end;
  root_.reset();
  return document;
}

// Only when nothing complete is left, so that many documents in one read cost one move.
void Framer::discard_consumed() {
  if (start_ == 0) return;
  buffer_.erase(0, start_);
  scanned_ -= start_;
  rooted_ -= start_;
  blank_until_ -= std::min(blank_until_, start_);
  start_ = 0;
}

}  // namespace aprsim::crcl
