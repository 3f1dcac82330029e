#include "crcl/framer.hpp"

#include <algorithm>
#include <utility>

#include "crcl/text.hpp"

namespace aprsim::crcl {
namespace {

constexpr std::string_view kSeparators("\0 \t\r\n", 5);
constexpr std::string_view kComment = "<!--", kCommentEnd = "-->";
constexpr std::string_view kData = "<![CDATA[", kDataEnd = "]]>";
// The first characters of a document in an encoding of two or four bytes a character: a byte order
// mark, or '<' beside a 0. Those before '<' are dropped as separators.
constexpr std::string_view kWide[] = {"\xFF\xFE", "\xFE\xFF", std::string_view("<\0", 2)};

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
}

bool Framer::wide_encoding() const {
  const std::string_view document = std::string_view(buffer_).substr(start_);
  return std::ranges::any_of(kWide, [&](std::string_view s) { return document.starts_with(s); });
}

// Searches from '<' to '<', so that every byte is examined once, however the stream is split.
template <typename IsTag>
std::size_t Framer::find_tag(const IsTag& is_tag) {
  const std::string_view all = buffer_;
  while (true) {
    if (!section_end_.empty()) {
      const std::size_t end = all.find(section_end_, scanned_);
      if (end == std::string::npos) {
        const std::size_t keep = section_end_.size() - 1;
        scanned_ = std::max(scanned_, all.size() - std::min(all.size(), keep));
        return std::string::npos;
      }
      scanned_ = end + section_end_.size();
      section_end_ = {};
    }
    scanned_ = std::min(all.find('<', scanned_), all.size());
    const std::string_view rest = all.substr(scanned_);
    if (rest.empty()) return std::string::npos;
    if (is_tag(rest)) return scanned_;
    if (rest.starts_with(kComment)) {
      scanned_ += kComment.size();
      section_end_ = kCommentEnd;
    } else if (rest.starts_with(kData)) {
      scanned_ += kData.size();
      section_end_ = kDataEnd;
    } else if (rest.size() < std::max(longest_, kData.size()) &&
               rest.find('>') == std::string_view::npos) {
      return std::string::npos;  // it may yet become one of them
    } else {
      ++scanned_;
    }
  }
}

// The kind of the document decides its end tag: a command may carry a program as text.
void Framer::find_root() {
  if (root_ || kinds_.size() == 1) {
    root_ = root_.value_or(0);
    return;
  }
  const auto begins = [this](std::string_view text) {
    for (std::size_t i = 0; i < kinds_.size(); ++i) {
      if (text.starts_with(kinds_[i].start_tag)) root_ = i;
    }
    // An end tag without a start tag ends the bytes before it.
    if (text.starts_with(kinds_[0].end_tag)) root_ = 0;
    return root_.has_value();
  };
  (void)find_tag(begins);
}

std::size_t Framer::find_end() {
  if (!root_) return std::string::npos;
  const std::string& end_tag = kinds_[*root_].end_tag;
  const auto ends = [&end_tag](std::string_view text) { return text.starts_with(end_tag); };
  while (true) {
    const std::size_t tag = find_tag(ends);
    if (tag == std::string::npos) return tag;
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
  if (wide_encoding()) {
    Error error;
    error.expected =
        "the document is in UTF-16 or UTF-32, expected UTF-8 or another encoding of single bytes";
    return tl::unexpected<Error>(std::move(error));
  }
  find_root();
  const std::size_t end = find_end();
  const bool complete = end != std::string::npos;
  const Kind& kind = kinds_[root_.value_or(0)];
  // A document that has not begun may still become the longest kind.
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
  start_ = scanned_ = end;
  root_.reset();
  return document;
}

// Called only when no complete document is left, so that many documents in one read cost one move.
void Framer::discard_consumed() {
  if (start_ == 0) return;
  buffer_.erase(0, start_);
  scanned_ -= start_;
  blank_until_ -= std::min(blank_until_, start_);
  start_ = 0;
}

}  // namespace aprsim::crcl
