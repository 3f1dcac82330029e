#include "clients/aprsim/trace/stream_framer.hpp"

#include <algorithm>
#include <cstdint>

#include "clients/aprsim/trace/simple_message_units.hpp"
#include "modbus/request_validator.hpp"

namespace aprsim::trace {
namespace {

constexpr std::size_t kMaxLineBytes = std::size_t{1} << 20;

crcl::Framer framer_of(bool from_client) {
  return from_client ? crcl::Framer::for_commands(crcl::kMaxProgramBytes, crcl::kMaxProgramBytes)
                     : crcl::Framer::for_statuses();
}

/// Position of the first document.
std::size_t find_document(std::string_view bytes) {
  return std::min({bytes.find("<?xml"), bytes.find("<CRCL")});
}

/// Whether this is a Modbus/TCP header: protocol 0 and a valid length.
bool begins_unit(std::string_view bytes) {
  const auto byte = [&](std::size_t at) { return static_cast<std::uint8_t>(bytes[at]); };
  return bytes.size() >= modbus::kHeaderSize && byte(2) == 0 && byte(3) == 0 && byte(4) == 0 &&
         byte(5) >= 2 && byte(5) <= modbus::kMaxPduSize + 1;
}

}  // namespace

StreamFramer::StreamFramer(v1::WireKind kind, bool from_client)
    : kind_(kind), from_client_(from_client), documents_(framer_of(from_client)) {}

void StreamFramer::lose() {
  documents_ = framer_of(from_client_);
  buffer_.clear();
  searching_ = true;
}

std::vector<std::string> StreamFramer::take(std::string_view bytes) {
  std::vector<std::string> out;
  if (!broken_.empty()) return out;
  if (kind_ == v1::WIRE_KIND_CRCL) take_documents(bytes, out);
  if (kind_ == v1::WIRE_KIND_MODBUS) take_units(bytes, out);
  if (kind_ == v1::WIRE_KIND_VISION) take_lines(bytes, out);
  if (kind_ == v1::WIRE_KIND_SIMPLE_MESSAGE) take_messages(bytes, out);
  return out;
}

void StreamFramer::take_documents(std::string_view bytes, std::vector<std::string>& out) {
  if (searching_) {
    // A segment's end may split the word, so the end of the previous segment is searched, too.
    buffer_ += bytes;
    const std::size_t begin = find_document(buffer_);
    if (begin == std::string_view::npos) {
      buffer_.erase(0, buffer_.size() - std::min<std::size_t>(buffer_.size(), 4));
      return;
    }
    searching_ = false;
    documents_.append(std::string_view(buffer_).substr(begin));
    buffer_.clear();
  } else {
    documents_.append(bytes);
  }
  while (true) {
    auto document = documents_.next();
    if (!document) {
      broken_ = document.error().message();
      return;
    }
    if (!*document) return;
    out.push_back(**std::move(document));
  }
}

void StreamFramer::take_units(std::string_view bytes, std::vector<std::string>& out) {
  // Resynchronise at a segment that begins like a unit.
  if (searching_) {
    if (buffer_.empty() && !begins_unit(bytes) && bytes.size() >= modbus::kHeaderSize) return;
    searching_ = false;
  }
  buffer_ += bytes;
  while (buffer_.size() >= modbus::kHeaderSize) {
    if (!begins_unit(buffer_)) return lose();
    const std::size_t size = modbus::kHeaderSize - 1 + static_cast<std::uint8_t>(buffer_[5]);
    if (buffer_.size() < size) return;
    out.push_back(buffer_.substr(0, size));
    buffer_.erase(0, size);
  }
}

void StreamFramer::take_messages(std::string_view bytes, std::vector<std::string>& out) {
  // Resynchronise at a segment that begins like a message.
  if (searching_ && buffer_.empty() && !simple_message_unit(bytes, from_client_)) return;
  searching_ = false;
  buffer_ += bytes;
  while (!buffer_.empty()) {
    const auto size = simple_message_unit(buffer_, from_client_);
    if (!size) return lose();
    if (*size == 0) return;
    out.push_back(buffer_.substr(0, *size));
    buffer_.erase(0, *size);
  }
}

void StreamFramer::take_lines(std::string_view bytes, std::vector<std::string>& out) {
  while (!bytes.empty()) {
    const std::size_t end = bytes.find('\n');
    buffer_ += bytes.substr(0, end == std::string_view::npos ? end : end + 1);
    if (end == std::string_view::npos) {
      if (buffer_.size() > kMaxLineBytes) lose();
      return;
    }
    bytes.remove_prefix(end + 1);
    // Drop the rest of a line that began before the capture: its fields come in groups of six.
    const auto commas = std::ranges::count(buffer_, ',');
    if (!searching_ || commas % 6 == 0) out.push_back(buffer_);
    searching_ = false;
    buffer_.clear();
  }
}

}  // namespace aprsim::trace
