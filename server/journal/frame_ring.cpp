#include "server/journal/frame_ring.hpp"

#include <algorithm>

namespace aprsim::server::journal {
namespace {

/// Parts of the ring; a segment that fills one makes the ring ask for a checkpoint.
constexpr std::size_t kSegments = 8;

}  // namespace

void FrameRing::add(const Frame& frame) {
  if (frame.begins) segments_.push_back({.clock = frame.clock, .bytes = 0, .frames = {}});
  // Frames without a checkpoint before them cannot be replayed.
  if (segments_.empty()) return;
  Segment& latest = segments_.back();
  latest.frames.push_back(frame.bytes);
  latest.bytes += frame.bytes->size();
  bytes_ += frame.bytes->size();
  const auto old = [&] {
    return segments_.size() > 1 && segments_[1].clock + max_steps_ <= frame.clock;
  };
  std::erase_if(held_, [](const auto& bytes) { return bytes.expired(); });
  const auto large = [&] { return bytes_ + held_bytes() > max_bytes_; };
  while (!segments_.empty() && (large() || old())) drop_oldest();
}

void FrameRing::drop_older_half() {
  for (std::size_t left = segments_.size() / 2; left > 0; --left) drop_oldest();
}

void FrameRing::drop_oldest() {
  for (const FrameBytes& bytes : segments_.front().frames) {
    if (bytes.use_count() > 1) held_.push_back(bytes);
  }
  bytes_ -= segments_.front().bytes;
  segments_.pop_front();
}

std::size_t FrameRing::held_bytes() const {
  std::size_t bytes = 0;
  for (const auto& held : held_) {
    if (const auto frame = held.lock()) bytes += frame->size();
  }
  return bytes;
}

std::vector<FrameBytes> FrameRing::last(std::uint64_t steps, std::uint64_t clock) const {
  const std::uint64_t from = clock - std::min(steps, clock);
  auto begin = std::ranges::find_if(segments_.rbegin(), segments_.rend(),
                                    [&](const Segment& segment) { return segment.clock <= from; });
  std::vector<FrameBytes> frames;
  auto segment = begin == segments_.rend() ? segments_.begin() : begin.base() - 1;
  for (; segment != segments_.end(); ++segment) {
    frames.insert(frames.end(), segment->frames.begin(), segment->frames.end());
  }
  return frames;
}

bool FrameRing::wants_beginning() const {
  if (max_bytes_ == 0) return false;
  return segments_.empty() || segments_.back().bytes > max_bytes_ / kSegments;
}

}  // namespace aprsim::server::journal
