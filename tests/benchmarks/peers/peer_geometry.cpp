#include "tests/benchmarks/peers/peer_geometry.hpp"

#include <set>
#include <stdexcept>

namespace aprsim::bench {
namespace {

PeerBox box(double x0, double x1, double y0, double y1, double z0, double z1) {
  return {.centre = {(x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2},
          .half = {(x1 - x0) / 2, (y1 - y0) / 2, (z1 - z0) / 2}};
}

/// The stretches that two holes around `centres` leave of min..max.
std::vector<std::pair<double, double>> webs(double min, double max, const std::set<double>& centres,
                                            double half) {
  std::vector<std::pair<double, double>> out;
  double from = min;
  for (const double centre : centres) {
    out.emplace_back(from, centre - half);
    from = centre + half;
  }
  out.emplace_back(from, max);
  return out;
}

}  // namespace

std::vector<PeerBox> tray_boxes(const scene::TrayType& tray) {
  std::set<double> columns, rows;
  for (const auto& slot : tray.slots) {
    columns.insert(slot.xy.x());
    rows.insert(slot.xy.y());
  }
  if (tray.slots.size() != 4 || columns.size() != 2 || rows.size() != 2) {
    throw std::invalid_argument(tray.name + " has not two by two pockets");
  }
  const auto& pocket = tray.slots.front().pocket;
  const double half = pocket.top_radius_m, z = -pocket.depth_m;
  const auto& min = tray.min_xy;
  const auto& max = tray.max_xy;
  std::vector<PeerBox> out = {box(min.x(), max.x(), min.y(), max.y(), -tray.thickness_m, z)};
  out.front().floor = true;
  for (const auto& [x0, x1] : webs(min.x(), max.x(), columns, half)) {
    out.push_back(box(x0, x1, min.y(), max.y(), z, 0));
  }
  for (const double column : columns) {
    for (const auto& [y0, y1] : webs(min.y(), max.y(), rows, half)) {
      out.push_back(box(column - half, column + half, y0, y1, z, 0));
    }
  }
  return out;
}

std::vector<PeerCylinder> gear_cylinders(const scene::GearType& gear) {
  return {{gear.disc_height_m / 2, gear.disc_radius_m, gear.disc_height_m / 2},
          {-gear.hub_height_m / 2, gear.hub_top_radius_m, gear.hub_height_m / 2}};
}

}  // namespace aprsim::bench
