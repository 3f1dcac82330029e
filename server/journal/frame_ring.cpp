#include "server/journal/frame_ring.hpp"

#include <algorithm>

namespace aprsim::server::journal {
namespace {

/// A stretch between two beginnings takes no more of the whole than one of so many parts.
constexpr std::size_t kStretches = 8;

}  // namespace

void FrameRing::add(const Frame& frame) {
  if (frame.begins) stretches_.push_back({.clock = frame.clock, .bytes = 0, .frames = {}});
  // Of what has no beginning nothing can be run.
  if (stretches_.empty()) return;
  Stretch& latest = stretches_.back();
  latest.frames.push_back(frame.bytes);
  latest.bytes += frame.bytes->size();
  bytes_ += frame.bytes->size();
  const auto old = [&] {
    return stretches_.size() > 1 && stretches_[1].clock + max_steps_ <= frame.clock;
  };
  while (!stretches_.empty() && (bytes_ > max_bytes_ || old())) {
    bytes_ -= stretches_.front().bytes;
    stretches_.pop_front();
  }
}

std::vector<FrameBytes> FrameRing::last(std::uint64_t steps, std::uint64_t clock) const {
  const std::uint64_t from = clock - std::min(steps, clock);
  auto begin = std::ranges::find_if(stretches_.rbegin(), stretches_.rend(),
                                    [&](const Stretch& stretch) { return stretch.clock <= from; });
  std::vector<FrameBytes> frames;
  auto stretch = begin == stretches_.rend() ? stretches_.begin() : begin.base() - 1;
  for (; stretch != stretches_.end(); ++stretch) {
    frames.insert(frames.end(), stretch->frames.begin(), stretch->frames.end());
  }
  return frames;
}

bool FrameRing::wants_beginning() const {
  if (max_bytes_ == 0) return false;
  return stretches_.empty() || stretches_.back().bytes > max_bytes_ / kStretches;
}

}  // namespace aprsim::server::journal
