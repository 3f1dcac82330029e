#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "world/render/mesh/material.hpp"

namespace aprsim::render {

/// A surface of triangles in its own frame. Corners run anticlockwise as seen from outside, where
/// alone a triangle is visible.
struct Mesh {
  struct Triangle {
    std::array<Eigen::Vector3f, 3> points;
    std::array<Eigen::Vector3f, 3> normals;  ///< of the smooth surface at the corners
    int material = 0;
  };
  std::vector<Triangle> triangles;
  std::vector<Material> materials;
};

using Outline = std::vector<Eigen::Vector2d>;

/// Adds shapes to a mesh.
class MeshBuilder {
 public:
  /// Frame in the mesh's frame of the shapes that follow.
  void set_frame(const Eigen::Isometry3d& X) { X_ = X; }
  void set_material(const Material& material);

  void triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);
  void box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size);
  /// A box with edges cut off at 45 degrees, `cut_m` from each face.
  void soft_box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, double cut_m);
  /// Surface of revolution about z through points (radius, z): smooth around, sharp between the
  /// points. The outside is to the right of the way through the points.
  void lathe(const std::vector<Eigen::Vector2d>& profile, int sides);
  /// Closed cylinder about z.
  void cylinder(double radius, double low, double high, int sides);
  void sphere(double radius, int sides);
  /// Walls over an anticlockwise outline; its outside is theirs.
  void walls(const Outline& outline, double low, double high);
  /// A plane polygon with holes that faces up, or down. The outline runs anticlockwise, holes run
  /// clockwise; they do not meet.
  void face(const Outline& outline, const std::vector<Outline>& holes, double z, bool up);
  /// The ring between two outlines with the same number of points; faces up, or down.
  void ring(const Outline& outer, const Outline& inner, double z, bool up);

  [[nodiscard]] Mesh take() { return std::move(mesh_); }

 private:
  void add(const std::array<Eigen::Vector3d, 3>& points,
           const std::array<Eigen::Vector3d, 3>& normals);
  void quad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
            const Eigen::Vector3d& d);

  Mesh mesh_;
  Eigen::Isometry3d X_ = Eigen::Isometry3d::Identity();
};

/// A regular polygon, anticlockwise.
[[nodiscard]] Outline circle(const Eigen::Vector2d& centre, double radius, int sides);

}  // namespace aprsim::render
