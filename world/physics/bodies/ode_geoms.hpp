#pragma once

#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/collision/shapes/contact.hpp"

struct dxGeom;

/// Collision of primitives by ODE (dCollide). ODE's errors and failed assertions throw
/// PhysicsFailure. Thread: any, one at a time.
namespace aprsim::physics {

/// A box, capsule, cylinder or sphere with a pose. Cylinders and capsules lie along their z axis.
class OdeGeom {
 public:
  [[nodiscard]] static OdeGeom box(const Eigen::Vector3d& size_m);
  /// `length_m`: of the cylindrical part.
  [[nodiscard]] static OdeGeom capsule(double radius_m, double length_m);
  [[nodiscard]] static OdeGeom cylinder(double radius_m, double length_m);
  [[nodiscard]] static OdeGeom sphere(double radius_m);

  /// Only for a box.
  void set_box_size(const Eigen::Vector3d& size_m);
  /// Only for a cylinder.
  void set_cylinder_size(double radius_m, double length_m);
  void set_pose(const Eigen::Isometry3d& X_WS);

 private:
  struct Destroy {
    void operator()(dxGeom* geom) const;
  };
  explicit OdeGeom(dxGeom* geom) : geom_(geom) {}
  friend void collide_geoms(const OdeGeom&, const OdeGeom&, BodyIndex, BodyIndex, SurfacePair,
                            std::vector<Contact>&);

  std::unique_ptr<dxGeom, Destroy> geom_;
};

/// Appends the contact points of two geoms, normals into `geom_a`; at most `kMaxGeomPoints`.
inline constexpr int kMaxGeomPoints = 4;
void collide_geoms(const OdeGeom& geom_a, const OdeGeom& geom_b, BodyIndex a, BodyIndex b,
                   SurfacePair pair, std::vector<Contact>& out);

}  // namespace aprsim::physics
