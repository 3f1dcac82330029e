#include "server/journal/journal_ring.hpp"

#include <utility>

#include "proto/journal/frames.hpp"

namespace aprsim::server::journal {

void JournalRing::begin_part(Clock::time_point now) {
  parts_.push_back({now, {}});
  // A part is over when the next one begins: it covers the time until then.
  while (parts_.size() > 1 && now - parts_[1].begin >= keep_) drop_oldest();
}

void JournalRing::append(std::string frame) {
  if (parts_.empty()) return;  // nothing to go on from
  bytes_ += frame.size();
  parts_.back().frames += std::move(frame);
  while (bytes_ > max_bytes_ && !parts_.empty()) drop_oldest();
}

std::string JournalRing::file(const std::string& header_frame) const {
  std::string out(aprsim::journal::kMagic);
  out += header_frame;
  for (const Part& part : parts_) out += part.frames;
  return out;
}

void JournalRing::drop_oldest() {
  bytes_ -= parts_.front().frames.size();
  parts_.pop_front();
}

}  // namespace aprsim::server::journal
