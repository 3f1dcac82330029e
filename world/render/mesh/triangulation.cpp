#include "world/render/mesh/triangulation.hpp"

#include <cstddef>
#include <limits>

namespace aprsim::render {
namespace {

using Point = Eigen::Vector2d;
using Loop = std::vector<Point>;

/// Twice the area of a triangle, positive where its corners run anticlockwise.
double area(const Point& a, const Point& b, const Point& c) {
  const Point u = b - a, v = c - a;
  return u.x() * v.y() - u.y() * v.x();
}

/// Whether two segments cross, each at a point within it.
bool cross(const Point& a, const Point& b, const Point& c, const Point& d) {
  return area(a, b, c) * area(a, b, d) < 0 && area(c, d, a) * area(c, d, b) < 0;
}

bool is_free(const Point& a, const Point& b, const Loop& loop) {
  for (std::size_t i = 0; i < loop.size(); ++i) {
    if (cross(a, b, loop[i], loop[(i + 1) % loop.size()])) return false;
  }
  return true;
}

/// Whether a line from corner i to p starts inside the loop. Bridges make corners with several
/// visits, which have a share of the angle each.
bool starts_inside(const Loop& loop, std::size_t i, const Point& p) {
  const std::size_t n = loop.size();
  const Point &a = loop[(i + n - 1) % n], &b = loop[i], &c = loop[(i + 1) % n];
  const bool left_of_first = area(a, b, p) > 0, left_of_second = area(b, c, p) > 0;
  return area(a, b, c) > 0 ? left_of_first && left_of_second : left_of_first || left_of_second;
}

/// Joins the hole nearest to the loop to it; returns that hole's index.
std::size_t join_nearest(Loop& loop, const std::vector<Loop>& holes) {
  double least = std::numeric_limits<double>::infinity();
  std::size_t hole = 0, from = 0, to = 0;
  for (std::size_t h = 0; h < holes.size(); ++h) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      for (std::size_t k = 0; k < holes[h].size(); ++k) {
        const double distance = (loop[i] - holes[h][k]).squaredNorm();
        if (distance >= least || !starts_inside(loop, i, holes[h][k]) ||
            !is_free(loop[i], holes[h][k], loop)) {
          continue;
        }
        least = distance;
        hole = h;
        from = i;
        to = k;
      }
    }
  }
  Loop joined(loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(from) + 1);
  for (std::size_t k = 0; k <= holes[hole].size(); ++k) {
    joined.push_back(holes[hole][(to + k) % holes[hole].size()]);
  }
  joined.insert(joined.end(), loop.begin() + static_cast<std::ptrdiff_t>(from), loop.end());
  loop = std::move(joined);
  return hole;
}

/// Whether corner i can be cut off: it is convex, and no other corner is in its triangle.
bool is_ear(const Loop& loop, std::size_t i) {
  const std::size_t n = loop.size();
  const Point &a = loop[(i + n - 1) % n], &b = loop[i], &c = loop[(i + 1) % n];
  if (!(area(a, b, c) > 0)) return false;
  for (const Point& p : loop) {
    if (p == a || p == b || p == c) continue;
    if (area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0) return false;
  }
  return true;
}

}  // namespace

std::vector<std::array<Point, 3>> triangulate(const Loop& outline, const std::vector<Loop>& holes) {
  Loop loop = outline;
  std::vector<Loop> rest = holes;
  while (!rest.empty()) {
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(join_nearest(loop, rest)));
  }
  std::vector<std::array<Point, 3>> triangles;
  std::size_t i = 0, tried = 0;
  while (loop.size() > 3 && tried < loop.size()) {
    const std::size_t n = loop.size();
    i %= n;
    if (!is_ear(loop, i)) {
      ++i;
      ++tried;
      continue;
    }
    triangles.push_back({loop[(i + n - 1) % n], loop[i], loop[(i + 1) % n]});
    loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(i));
    // Not the next corner: ears all around leave wider triangles than a fan.
    tried = 0;
    ++i;
  }
  if (loop.size() == 3) triangles.push_back({loop[0], loop[1], loop[2]});
  return triangles;
}

}  // namespace aprsim::render
