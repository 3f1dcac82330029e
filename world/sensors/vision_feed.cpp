#include "world/sensors/vision_feed.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "world/sensors/random.hpp"

namespace aprsim::sensors {
namespace {

std::uint64_t steps_in(double span_s, SimTime step_size) {
  return static_cast<std::uint64_t>(std::llround(span_s / seconds(step_size)));
}

}  // namespace

VisionFeed::VisionFeed(const scene::Vision& vision, const Eigen::Isometry3d& X_WR,
                       SimTime step_size, std::uint64_t seed, std::size_t body_count)
    : camera_(vision, X_WR),
      step_size_(step_size),
      seed_(seed),
      period_steps_(std::max<std::uint64_t>(1, steps_in(1 / vision.rate_hz, step_size))),
      latency_steps_(steps_in(vision.latency_s, step_size)),
      ring_(latency_steps_ / period_steps_ + 2) {
  latest_.detections.reserve(body_count);
  for (auto& pending : ring_) pending.frame.detections.reserve(body_count);
}

void VisionFeed::expose(std::uint64_t step, const api::CellDescription& cell,
                        std::span<const Eigen::Isometry3d> X_WP,
                        std::span<const Occluder> occluders) {
  Pending& pending = ring_[(first_ + count_) % ring_.size()];
  ++count_;
  ++exposures_;
  camera_.detect(cell, X_WP, occluders, mix_seed(seed_, exposures_), pending.frame);
  pending.frame.number = exposures_;
  pending.frame.time = step_size_ * static_cast<SimTime::rep>(step);
  pending.out_at = exposures_ == 1 ? step : step + latency_steps_;
}

void VisionFeed::advance(std::uint64_t step) {
  while (count_ > 0 && ring_[first_].out_at <= step) {
    std::swap(latest_, ring_[first_].frame);
    first_ = (first_ + 1) % ring_.size();
    --count_;
  }
}

}  // namespace aprsim::sensors
