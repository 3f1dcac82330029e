#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "clients/aprsim/trace/action.hpp"

namespace aprsim::trace {
namespace {

constexpr std::size_t kFrames = 12;      // of which the last picture is made
constexpr std::size_t kLeastFrames = 4;  // that have to show a thing
constexpr double kSameThing_mm = 15;     // from frame to frame

/// One sighting, "name,rotation,x,y,score,type,"; false for a slot that nothing was seen in.
bool next_seen(std::string_view& line, Seen& out) {
  std::string_view fields[6];
  for (std::string_view& field : fields) {
    const std::size_t comma = std::min(line.find(','), line.size());
    field = line.substr(0, comma);
    line.remove_prefix(std::min(comma + 1, line.size()));
    while (line.starts_with(' ')) line.remove_prefix(1);
  }
  const auto number = [](std::string_view text, double& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
  };
  out.name = fields[0];
  out.type = fields[5];
  return number(fields[1], out.rotation_rad) && number(fields[2], out.x_mm) &&
         number(fields[3], out.y_mm);
}

/// A thing over several frames.
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
    std::string_view line = frames[i]->wire.data();
    while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
    while (!line.empty()) {
      Seen seen;
      if (next_seen(line, seen)) add_to(clusters, seen);
    }
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
