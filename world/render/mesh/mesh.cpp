#include "world/render/mesh/mesh.hpp"

#include <cmath>
#include <numbers>

#include "world/render/mesh/triangulation.hpp"

namespace aprsim::render {
namespace {

/// Corner i of n on the unit circle; the last leads to the first with the same bits.
Eigen::Vector2d on_circle(int i, int n) {
  const double angle = 2 * std::numbers::pi * (i % n) / n;
  return {std::cos(angle), std::sin(angle)};
}

Eigen::Vector3d turned(const Eigen::Vector2d& direction, double radius, double z) {
  return {radius * direction.x(), radius * direction.y(), z};
}

}  // namespace

Outline circle(const Eigen::Vector2d& centre, double radius, int sides) {
  Outline out;
  for (int i = 0; i < sides; ++i) out.push_back(centre + radius * on_circle(i, sides));
  return out;
}

void MeshBuilder::set_material(const Material& material) { mesh_.materials.push_back(material); }

void MeshBuilder::add(const std::array<Eigen::Vector3d, 3>& points,
                      const std::array<Eigen::Vector3d, 3>& normals) {
  Mesh::Triangle out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.points[i] = (X_ * points[i]).cast<float>();
    out.normals[i] = (X_.linear() * normals[i]).normalized().cast<float>();
  }
  if (out.points[0] == out.points[1] || out.points[1] == out.points[2] ||
      out.points[2] == out.points[0]) {
    return;
  }
  if (mesh_.materials.empty()) mesh_.materials.emplace_back();
  out.material = static_cast<int>(mesh_.materials.size()) - 1;
  mesh_.triangles.push_back(out);
}

void MeshBuilder::triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                           const Eigen::Vector3d& c) {
  const Eigen::Vector3d n = (b - a).cross(c - a);
  if (n.squaredNorm() > 0) add({a, b, c}, {n, n, n});
}

void MeshBuilder::quad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                       const Eigen::Vector3d& d) {
  triangle(a, b, c);
  triangle(a, c, d);
}

void MeshBuilder::box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size) {
  const Eigen::Vector3d h = 0.5 * size;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Eigen::Vector3d n = Eigen::Vector3d::Zero(), u = n, v = n;
      n(axis) = side * h(axis);
      u((axis + 1) % 3) = side * h((axis + 1) % 3);
      v((axis + 2) % 3) = h((axis + 2) % 3);
      quad(centre + n - u - v, centre + n + u - v, centre + n + u + v, centre + n - u + v);
    }
  }
}

void MeshBuilder::soft_box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size,
                           double cut_m) {
  const Eigen::Vector3d h = 0.5 * size;
  const double cut = std::min(cut_m, 0.45 * h.minCoeff());
  if (!(cut > 0)) return box(centre, size);
  const Eigen::Vector3d in = h - Eigen::Vector3d::Constant(cut);
  // Corner `s` of the face across `axis`.
  const auto corner = [&](int axis, const Eigen::Vector3d& s) {
    Eigen::Vector3d p = s.cwiseProduct(in);
    p(axis) = s(axis) * h(axis);
    return Eigen::Vector3d(centre + p);
  };
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    for (const double side : {-1.0, 1.0}) {
      Eigen::Vector3d s;
      const auto at = [&](double along_b, double along_c) {
        s(a) = side;
        s(b) = side * along_b;
        s(c) = along_c;
        return corner(a, s);
      };
      quad(at(-1, -1), at(1, -1), at(1, 1), at(-1, 1));
    }
    // The cut edges along c, between the faces across a and b.
    for (const double sa : {-1.0, 1.0}) {
      for (const double sb : {-1.0, 1.0}) {
        Eigen::Vector3d low, high;
        low(a) = high(a) = sa;
        low(b) = high(b) = sb;
        low(c) = -1;
        high(c) = 1;
        if (sa * sb > 0) {
          quad(corner(a, low), corner(b, low), corner(b, high), corner(a, high));
        } else {
          quad(corner(b, low), corner(a, low), corner(a, high), corner(b, high));
        }
      }
    }
  }
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d s((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    if (s.prod() > 0) {
      triangle(corner(0, s), corner(1, s), corner(2, s));
    } else {
      triangle(corner(0, s), corner(2, s), corner(1, s));
    }
  }
}

void MeshBuilder::lathe(const std::vector<Eigen::Vector2d>& profile, int sides) {
  for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
    const Eigen::Vector2d &low = profile[k], &high = profile[k + 1];
    const Eigen::Vector2d across(high.y() - low.y(), low.x() - high.x());
    if (across.squaredNorm() == 0) continue;
    for (int i = 0; i < sides; ++i) {
      const Eigen::Vector2d a = on_circle(i, sides), b = on_circle(i + 1, sides);
      const Eigen::Vector3d na = turned(a, across.x(), across.y()),
                            nb = turned(b, across.x(), across.y());
      const Eigen::Vector3d low_a = turned(a, low.x(), low.y()),
                            low_b = turned(b, low.x(), low.y()),
                            high_a = turned(a, high.x(), high.y()),
                            high_b = turned(b, high.x(), high.y());
      add({low_a, low_b, high_b}, {na, nb, nb});
      add({low_a, high_b, high_a}, {na, nb, na});
    }
  }
}

void MeshBuilder::cylinder(double radius, double low, double high, int sides) {
  lathe({{0, low}, {radius, low}, {radius, high}, {0, high}}, sides);
}

void MeshBuilder::sphere(double radius, int sides) {
  const int rings = sides / 2;
  const auto point = [&](int ring, const Eigen::Vector2d& around) -> Eigen::Vector3d {
    const double angle = std::numbers::pi * ring / rings;
    const double r = ring == 0 || ring == rings ? 0 : std::sin(angle);
    return turned(around, r, -std::cos(angle));
  };
  for (int k = 0; k < rings; ++k) {
    for (int i = 0; i < sides; ++i) {
      const Eigen::Vector2d a = on_circle(i, sides), b = on_circle(i + 1, sides);
      const Eigen::Vector3d p = point(k, a), q = point(k, b), r = point(k + 1, b),
                            s = point(k + 1, a);
      add({radius * p, radius * q, radius * r}, {p, q, r});
      add({radius * p, radius * r, radius * s}, {p, r, s});
    }
  }
}

void MeshBuilder::walls(const Outline& outline, double low, double high) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    quad({a.x(), a.y(), low}, {b.x(), b.y(), low}, {b.x(), b.y(), high}, {a.x(), a.y(), high});
  }
}

void MeshBuilder::face(const Outline& outline, const std::vector<Outline>& holes, double z,
                       bool up) {
  for (const auto& [a, b, c] : triangulate(outline, holes)) {
    const Eigen::Vector3d pa(a.x(), a.y(), z), pb(b.x(), b.y(), z), pc(c.x(), c.y(), z);
    if (up) {
      triangle(pa, pb, pc);
    } else {
      triangle(pa, pc, pb);
    }
  }
}

void MeshBuilder::ring(const Outline& outer, const Outline& inner, double z, bool up) {
  for (std::size_t i = 0; i < outer.size(); ++i) {
    const std::size_t k = (i + 1) % outer.size();
    const Eigen::Vector3d a(inner[i].x(), inner[i].y(), z), b(outer[i].x(), outer[i].y(), z),
        c(outer[k].x(), outer[k].y(), z), d(inner[k].x(), inner[k].y(), z);
    if (up) {
      quad(a, b, c, d);
    } else {
      quad(a, d, c, b);
    }
  }
}

}  // namespace aprsim::render
