#include "world/physics/bodies/ode_geoms.hpp"

#include <array>

#include <ode/ode.h>

#include "world/physics/bodies/ode_library.hpp"

namespace aprsim::physics {
namespace {

Eigen::Vector3d vector(const dReal* v) { return {v[0], v[1], v[2]}; }

}  // namespace

void OdeGeom::Destroy::operator()(dxGeom* geom) const { dGeomDestroy(geom); }

OdeGeom OdeGeom::box(const Eigen::Vector3d& size_m) {
  prepare_ode();
  return OdeGeom(dCreateBox(nullptr, size_m.x(), size_m.y(), size_m.z()));
}

OdeGeom OdeGeom::capsule(double radius_m, double length_m) {
  prepare_ode();
  return OdeGeom(dCreateCapsule(nullptr, radius_m, length_m));
}

OdeGeom OdeGeom::cylinder(double radius_m, double length_m) {
  prepare_ode();
  return OdeGeom(dCreateCylinder(nullptr, radius_m, length_m));
}

OdeGeom OdeGeom::sphere(double radius_m) {
  prepare_ode();
  return OdeGeom(dCreateSphere(nullptr, radius_m));
}

void OdeGeom::set_box_size(const Eigen::Vector3d& size_m) {
  dGeomBoxSetLengths(geom_.get(), size_m.x(), size_m.y(), size_m.z());
}

void OdeGeom::set_cylinder_size(double radius_m, double length_m) {
  dGeomCylinderSetParams(geom_.get(), radius_m, length_m);
}

void OdeGeom::set_pose(const Eigen::Isometry3d& X_WS) {
  const Eigen::Matrix3d& R = X_WS.linear();
  // ODE's rows are padded to four.
  const dMatrix3 rotation = {R(0, 0), R(0, 1), R(0, 2), 0,       R(1, 0), R(1, 1),
                             R(1, 2), 0,       R(2, 0), R(2, 1), R(2, 2), 0};
  dGeomSetRotation(geom_.get(), rotation);
  dGeomSetPosition(geom_.get(), X_WS.translation().x(), X_WS.translation().y(),
                   X_WS.translation().z());
}

void collide_geoms(const OdeGeom& geom_a, const OdeGeom& geom_b, BodyIndex a, BodyIndex b,
                   SurfacePair pair, std::vector<Contact>& out) {
  prepare_ode();
  std::array<dContactGeom, kMaxGeomPoints> points;
  // ODE's normals point into the first geom, as ours do.
  const int count = dCollide(geom_a.geom_.get(), geom_b.geom_.get(), kMaxGeomPoints, points.data(),
                             sizeof(dContactGeom));
  for (int i = 0; i < count; ++i) {
    const auto& point = points[static_cast<std::size_t>(i)];
    out.push_back({a, b, vector(point.pos), vector(point.normal), point.depth, pair});
  }
}

}  // namespace aprsim::physics
