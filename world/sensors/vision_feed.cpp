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

void VisionFeed::expose(std::uint64_t step, std::span<const scene::FreeBody> bodies,
                        std::span<const Eigen::Isometry3d> X_WP,
                        std::span<const Occluder> occluders) {
  // Consecutive numbers give each frame the same noise, whatever preceded it.
  ++exposures_;
  if (faults_ && faults_->outage) return;
  Pending& pending = ring_[(first_ + count_) % ring_.size()];
  ++count_;
  camera_.detect(bodies, X_WP, occluders, mix_seed(seed_, exposures_), pending.frame);
  pending.frame.number = exposures_;
  pending.frame.time = step_size_ * static_cast<SimTime::rep>(step);
  pending.out_at = exposures_ == 1 ? step : step + latency_steps_;
  if (!faults_) return;
  if (faults_->frozen) {
    pending.frame.detections = frozen_;
  } else {
    spoil(*faults_, bodies, mix_seed(seed_, exposures_), pending.frame.detections);
  }
  pending.out_at += steps_in(faults_->late_s, step_size_);
}

void VisionFeed::advance_still(std::uint64_t first, std::uint64_t last,
                               std::span<const scene::FreeBody> bodies,
                               std::span<const Eigen::Isometry3d> X_WP,
                               std::span<const Occluder> occluders) {
  // Each exposure writes the next place of the ring, and a published frame is swapped out of it: as
  // many exposures as there are frames replace them all. Those before only move the places.
  const std::uint64_t seen = (ring_.size() + 1) * period_steps_;
  for (std::uint64_t step = first_due(first); step <= last; step += period_steps_) {
    if (step > 0) advance(step - 1);
    if (faults_ || last - step <= seen) {
      expose(step, bodies, X_WP, occluders);
    } else {
      ++exposures_;
      ring_[(first_ + count_) % ring_.size()].out_at = step + latency_steps_;
      ++count_;
    }
    advance(step);
  }
  advance(last);
}

void VisionFeed::set_faults(std::shared_ptr<const CameraFaults> faults) {
  const bool was_frozen = faults_ && faults_->frozen;
  if (faults && faults->frozen && !was_frozen) frozen_ = latest_.detections;
  faults_ = std::move(faults);
  if (!faults_) return;
  // Room for the frames that wait longer, in their order.
  const std::uint64_t wait = latency_steps_ + steps_in(faults_->late_s, step_size_);
  const std::size_t room = wait / period_steps_ + 2;
  if (room <= ring_.size()) return;
  std::rotate(ring_.begin(), ring_.begin() + static_cast<std::ptrdiff_t>(first_), ring_.end());
  first_ = 0;
  ring_.resize(room);
}

void VisionFeed::advance(std::uint64_t step) {
  while (count_ > 0 && ring_[first_].out_at <= step) {
    std::swap(latest_, ring_[first_].frame);
    first_ = (first_ + 1) % ring_.size();
    --count_;
  }
}

void VisionFeed::renumber(std::span<const int> new_of) {
  const auto change = [new_of](std::vector<api::VisionDetection>& seen) {
    for (api::VisionDetection& one : seen) {
      if (one.body >= 0) one.body = new_of[static_cast<std::size_t>(one.body)];
    }
  };
  for (Pending& pending : ring_) change(pending.frame.detections);
  change(latest_.detections);
  change(frozen_);
}

}  // namespace aprsim::sensors
