#include "protocols/vision/vision_line.hpp"

#include <cstddef>
#include <iterator>
#include <vector>

#include <fmt/format.h>

namespace aprsim::vision_server {
namespace {

const char* type_code(api::BodyKind kind) {
  switch (kind) {
    case api::BodyKind::kGear:
    case api::BodyKind::kPart:
      return "P";
    case api::BodyKind::kPartTray:
      return "PT";
    case api::BodyKind::kKitTray:
      return "KT";
  }
  return "P";
}

}  // namespace

std::string vision_line(const api::VisionFrame& frame, const api::CellDescription& cell,
                        bool empty_slots) {
  std::string line;
  const auto out = std::back_inserter(line);
  std::vector<bool> detected(cell.bodies.size());
  for (const auto& seen : frame.detections) {
    const auto index = static_cast<std::size_t>(seen.body);
    if (index >= cell.bodies.size()) continue;
    detected[index] = true;
    const auto& body = cell.bodies[index];
    fmt::format_to(out, "{},{:.4f},{:.3f},{:.3f},{:.2f},{},", body.type, seen.rotation_rad,
                   seen.x_m * 1e3, seen.y_m * 1e3, seen.score, type_code(body.kind));
  }
  for (std::size_t i = 0; empty_slots && i < cell.bodies.size(); ++i) {
    if (detected[i]) continue;
    fmt::format_to(out, "{},,,,,{},", cell.bodies[i].type, type_code(cell.bodies[i].kind));
  }
  line += '\n';
  return line;
}

}  // namespace aprsim::vision_server
