#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "clients/aprsim/trace/action.hpp"
#include "clients/wires/vision_frame.hpp"

namespace aprsim::trace {
namespace {

constexpr std::size_t kFrames = 12;      // at the end that make the final scene
constexpr std::size_t kLeastFrames = 4;  // that must show an object
constexpr double kSameThing_mm = 15;     // of one object between frames

/// The detections of one frame; empty for an unreadable line.
std::vector<Seen> seen_in(std::string_view line) {
  std::vector<Seen> out;
  const auto objects = client::decode_vision_line(line);
  if (!objects) return out;
  for (const client::VisionObject& object : *objects) {
    if (!object.detected) continue;
    out.push_back({.name = object.name,
                   .type = object.kind,
                   .x_mm = 1e3 * object.x_m,
                   .y_mm = 1e3 * object.y_m,
                   .rotation_rad = object.rotation_rad});
  }
  return out;
}

/// An object over several frames.
struct Cluster {
  Seen sum;
  double cosine = 0, sine = 0;  ///< of twice the rotation: trays may be taken for half a turn
  std::size_t count = 0;
};

void add_to(std::vector<Cluster>& clusters, const Seen& seen) {
  auto at = std::ranges::find_if(clusters, [&](const Cluster& cluster) {
    const auto n = static_cast<double>(cluster.count);
    return cluster.sum.name == seen.name &&
           std::hypot(cluster.sum.x_mm / n - seen.x_mm, cluster.sum.y_mm / n - seen.y_mm) <
               kSameThing_mm;
  });
  if (at == clusters.end()) {
    at = clusters.insert(at, Cluster{.sum = {.name = seen.name, .type = seen.type}});
  }
  at->sum.x_mm += seen.x_mm;
  at->sum.y_mm += seen.y_mm;
  at->cosine += std::cos(2 * seen.rotation_rad);
  at->sine += std::sin(2 * seen.rotation_rad);
  ++at->count;
}

}  // namespace

WireActions vision_actions(const Records& records) {
  WireActions out;
  std::vector<const WireRecord*> frames;
  for (const WireRecord* record : records) {
    if (record->wire.content() == v1::WIRE_CONTENT_SENT) frames.push_back(record);
  }
  out.polls = frames.size();
  const std::size_t count = std::min(frames.size(), kFrames);
  std::vector<Cluster> clusters;
  for (std::size_t i = frames.size() - count; i < frames.size(); ++i) {
    for (const Seen& seen : seen_in(frames[i]->wire.data())) add_to(clusters, seen);
  }
  for (const Cluster& cluster : clusters) {
    if (cluster.count < std::min(count, kLeastFrames)) continue;
    const auto n = static_cast<double>(cluster.count);
    out.seen.push_back({.name = cluster.sum.name,
                        .type = cluster.sum.type,
                        .x_mm = cluster.sum.x_mm / n,
                        .y_mm = cluster.sum.y_mm / n,
                        .rotation_rad = std::atan2(cluster.sine, cluster.cosine) / 2});
  }
  return out;
}

}  // namespace aprsim::trace
