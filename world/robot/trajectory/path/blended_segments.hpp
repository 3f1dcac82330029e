#pragma once

#include <cstddef>
#include <vector>

#include "world/robot/trajectory/profile/shared_parts.hpp"

namespace aprsim::robot {

/// The progress of each segment of a path over the path's own time s: its duration with every
/// segment at full speed. At a corner the two segments may overlap: the speed of one falls while
/// that of the other rises (cubic smoothstep), so that a path that superposes its segments rounds
/// the corner with continuous velocity and acceleration. Thread: any.
class BlendedSegments {
 public:
  void clear() { segments_.clear(); }
  /// `duration_s` > 0.
  void add(double duration_s);
  /// Overlap of segments `corner` and `corner + 1`, to either side of the end of the one; at most
  /// half the shorter one.
  void blend(std::size_t corner, double half_width_s);

  [[nodiscard]] std::size_t size() const { return segments_.size(); }
  [[nodiscard]] double length() const;
  [[nodiscard]] double begin(std::size_t segment) const { return segments_[segment].begin; }
  [[nodiscard]] double duration(std::size_t segment) const { return segments_[segment].duration; }
  /// The widest blend that the corner has room for.
  [[nodiscard]] double room(std::size_t corner) const;

  /// Progress of `segment` at s: 0 before it, 1 behind it.
  [[nodiscard]] double share(std::size_t segment, double s) const;
  /// First, second and third derivative of share().
  [[nodiscard]] double rate(std::size_t segment, double s) const;
  [[nodiscard]] double curvature(std::size_t segment, double s) const;
  [[nodiscard]] double third_derivative(std::size_t segment, double s) const;
  /// The segments that may be under way at s: first and last, at most two apart.
  struct Range {
    std::size_t first = 0, last = 0;
  };
  [[nodiscard]] Range active(double s) const;
  /// Where the next blend begins or ends after s, or the end of the path.
  [[nodiscard]] double next_break(double s) const;
  /// A step that resolves the segment or blend at s.
  [[nodiscard]] double fine_step(double s) const;

  /// Allocated memory, besides the value itself.
  [[nodiscard]] std::size_t bytes() const { return bytes_of(segments_); }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [all] = self;
    io(all);
  }

 private:
  struct Segment {
    double begin = 0, duration = 0;
    double blend_in = 0, blend_out = 0;  ///< half widths

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [begin, duration, blend_in, blend_out] = self;
      io(begin, duration, blend_in, blend_out);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.require(duration > 0 && blend_in >= 0 && blend_out >= 0 &&
                     blend_in + blend_out <= duration * (1 + 1e-9),
                 "blends longer than their segment");
    }
  };
  [[nodiscard]] std::size_t at(double s) const;

  std::vector<Segment> segments_;
};

}  // namespace aprsim::robot
