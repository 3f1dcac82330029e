#pragma once

#include <string>
#include <utility>
#include <vector>

namespace aprsim::bench {

struct Series {
  std::string name;
  std::vector<std::pair<double, double>> points;
};

struct Axis {
  std::string label;
  bool log = false;  ///< decades; points that are not positive are drawn at `floor`
  double floor = 0;  ///< smallest value shown on a log axis, 0 = smallest positive one
};

/// A line plot with markers and a legend.
struct Plot {
  std::string title;
  Axis x, y;
  std::vector<Series> series;

  /// A whole SVG document. Points with a not-finite coordinate are left out.
  [[nodiscard]] std::string svg() const;
};

}  // namespace aprsim::bench
