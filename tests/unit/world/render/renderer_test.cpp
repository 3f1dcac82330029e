#include "world/render/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "world/render/cell/part_meshes.hpp"

namespace aprsim::render {
namespace {

constexpr double kHeight_m = 1.5;
constexpr double kTolerance_m = 1e-4;

/// Looks down from 1.5 m with the lens of the laboratory's camera over the Fanuc's table.
scene::Camera overhead_camera() {
  scene::Camera camera;
  camera.X_PC.p = {0, 0, kHeight_m};
  camera.X_PC.q = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  camera.lens.width_px = 641;
  camera.lens.height_px = 361;
  camera.lens.focal_px = {878, 878};
  camera.lens.centre_px = {320, 180};
  camera.lens.distortion = {-0.177, 0, 0, 0, 0};
  return camera;
}

Lamp lamp() { return {.p_W = {0.5, -0.4, 2.5}, .radius_m = 0.08, .brightness = 0.6F}; }

Mesh ground_mesh() {
  MeshBuilder mesh;
  mesh.face({{-3, -3}, {3, -3}, {3, 3}, {-3, 3}}, {}, 0, true);
  return mesh.take();
}

Mesh sphere_mesh(double radius) {
  MeshBuilder mesh;
  mesh.sphere(radius, 400);
  return mesh.take();
}

/// Direction of a pixel in the world, 1 long along the view.
Eigen::Vector3d ray(const scene::Camera& camera, int x, int y) {
  const Eigen::Vector2d d = *camera.lens.direction({x, y});
  return camera.X_PC.q * Eigen::Vector3d(d.x(), d.y(), 1);
}

Placement at(const Mesh& mesh, const Eigen::Vector3d& p) {
  Placement out{.mesh = &mesh};
  out.X_W.translation() = p;
  return out;
}

TEST(Renderer, DepthOfAPlaneIsExact) {
  scene::Camera camera = overhead_camera();
  camera.X_PC.q = camera.X_PC.q * Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 0).normalized());
  const Mesh ground = ground_mesh();
  Renderer renderer(camera, {}, 1);
  renderer.draw({at(ground, {0, 0, 0})}, 1);
  const Picture<float> depth = renderer.depth();
  for (int y = 0; y < depth.height; y += 3) {
    for (int x = 0; x < depth.width; x += 3) {
      ASSERT_NEAR(*depth.at(x, y), -kHeight_m / ray(camera, x, y).z(), kTolerance_m);
    }
  }
}

TEST(Renderer, DepthAndNormalsOfASphereAreExact) {
  constexpr double kRadius_m = 0.15;
  const scene::Camera camera = overhead_camera();
  const Mesh sphere = sphere_mesh(kRadius_m);
  const Eigen::Vector3d centre(0.1, 0.05, 0.05);
  Renderer renderer(camera, {}, 1);
  renderer.draw({at(sphere, centre)}, 1);
  const Picture<float> depth = renderer.depth(), normals = renderer.normals();
  int inside = 0;
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      const Eigen::Vector3d d = ray(camera, x, y), o = camera.X_PC.p - centre;
      // |o + t d| = r.
      const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - kRadius_m * kRadius_m;
      const double root = b * b - a * c;
      if (root < 1e-3) continue;  // beside it, or grazed
      const double t = (-b - std::sqrt(root)) / a;
      ASSERT_NEAR(*depth.at(x, y), t, kTolerance_m);
      const Eigen::Vector3d normal = (o + t * d) / kRadius_m;
      const Eigen::Map<const Eigen::Vector3f> seen(normals.at(x, y));
      ASSERT_LT((seen.cast<double>() - normal).norm(), 1e-3);
      ++inside;
    }
  }
  EXPECT_GT(inside, 10000);
}

scene::GearType gear_type() {
  scene::GearType type;
  type.disc_radius_m = type.teeth_outer_radius_m = 0.05;
  type.disc_height_m = 0.006;
  type.peg_radius_m = 0.004;
  type.peg_top_m = 0.026;
  return type;
}

TEST(Renderer, DepthOfAGearIsExact) {
  const scene::Camera camera = overhead_camera();
  const Mesh gear = gear_mesh(gear_type(), 0xff0000), ground = ground_mesh();
  const Eigen::Vector3d centre(0.2, -0.1, 0.015);
  Renderer renderer(camera, {}, 1);
  renderer.draw({at(ground, {0, 0, 0}), at(gear, centre)}, 1);
  const Picture<float> depth = renderer.depth();
  const Picture<std::uint16_t> segments = renderer.segments({1, 2});
  int disc = 0, peg = 0;
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      const Eigen::Vector3d d = ray(camera, x, y);
      const auto at_height = [&](double z) -> Eigen::Vector3d {
        return camera.X_PC.p + (z - kHeight_m) / d.z() * d - centre;
      };
      const double top = at_height(0.041).head<2>().norm(),
                   face = at_height(0.021).head<2>().norm();
      if (top < 0.0038) {
        ASSERT_NEAR(*depth.at(x, y), kHeight_m - 0.041, kTolerance_m);
        ASSERT_EQ(*segments.at(x, y), 2);
        ++peg;
      } else if (face > 0.02 && face < 0.044) {
        ASSERT_NEAR(*depth.at(x, y), kHeight_m - 0.021, kTolerance_m);
        ASSERT_EQ(*segments.at(x, y), 2);
        ++disc;
      } else if (face > 0.052) {
        ASSERT_EQ(*segments.at(x, y), 1);
      }
    }
  }
  EXPECT_GT(disc, 1000);
  EXPECT_GT(peg, 10);
}

TEST(Renderer, WhatRestsIsNotDrawnAgain) {
  const Mesh gear = gear_mesh(gear_type(), 0xff0000), ground = ground_mesh();
  std::vector<Placement> placements = {at(ground, {0, 0, 0}), at(gear, {0.1, 0, 0.1})};
  Renderer renderer(overhead_camera(), {lamp()}, 1);
  EXPECT_EQ(renderer.draw(placements, 1).value(), renderer.tiles());
  EXPECT_EQ(renderer.draw(placements, 2).value(), 0U);
  placements[1].X_W.translation().x() += 0.002;
  const std::size_t drawn = renderer.draw(placements, 3).value();
  EXPECT_GT(drawn, 0U);
  EXPECT_LT(drawn, renderer.tiles() / 4);
}

TEST(Renderer, APictureDependsOnTheStateAlone) {
  const Mesh gear = gear_mesh(gear_type(), 0xff0000), ground = ground_mesh();
  std::vector<Placement> placements = {at(ground, {0, 0, 0}), at(gear, {-0.2, 0, 0.3}),
                                       at(gear, {-0.2, 0, 0.05})};
  scene::Camera camera = overhead_camera();
  camera.noise = 2;
  Renderer moved(camera, {lamp()}, 1);
  for (std::uint64_t frame = 1; frame <= 8; ++frame) {
    placements[1].X_W.translation().x() += 0.05;
    placements[1].X_W.rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()));
    moved.draw(placements, frame);
    Renderer fresh(camera, {lamp()}, 1);
    fresh.draw(placements, frame, 2);
    ASSERT_EQ(moved.rgb().values, fresh.rgb().values) << "frame " << frame;
    ASSERT_EQ(moved.depth().values, fresh.depth().values) << "frame " << frame;
  }
}

TEST(Renderer, ABlockBetweenLampAndGroundThrowsAShadow) {
  MeshBuilder builder;
  builder.box({0, 0, 0}, {0.1, 0.1, 0.01});
  const Mesh block = builder.take(), ground = ground_mesh();
  scene::Camera camera = overhead_camera();
  Lamp above = lamp();
  above.p_W = {-0.6, 0, 2};
  Renderer renderer(camera, {above}, 1);
  renderer.draw({at(ground, {0, 0, 0}), at(block, {0, 0, 0.3})}, 1);
  // The middle of the shadow is on the line from the lamp through the block.
  const auto brightness = [&](double x) {
    const Eigen::Vector3d p = camera.X_PC.q.inverse() * (Eigen::Vector3d(x, 0, 0) - camera.X_PC.p);
    const Eigen::Vector2d pixel = camera.lens.pixel(p.head<2>() / p.z());
    return static_cast<int>(*renderer.rgb().at(static_cast<int>(std::lround(pixel.x())),
                                               static_cast<int>(std::lround(pixel.y()))));
  };
  const double shadow = 0.6 * 0.3 / 1.7;
  EXPECT_LT(brightness(shadow), brightness(shadow + 0.15) - 20);
  // The shadow's edge at 0.05 * 2 / 1.7 from its middle is as wide as the lamp makes it.
  const double edge = shadow + 0.05 * 2 / 1.7;
  EXPECT_GT(brightness(edge), brightness(shadow) + 5);
  EXPECT_LT(brightness(edge), brightness(shadow + 0.15) - 5);
}

/// Camera whose codes are nearly the light itself.
scene::Camera plain_camera() {
  scene::Camera camera = overhead_camera();
  camera.blur_px = 0;
  return camera;
}

/// Light of a matt grey surface: even, from above, and by Lambert's law.
double lambert(const Lamp& lamp, const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d to_lamp = lamp.p_W - p;
  const double slope = std::max(0.0, normal.dot(to_lamp.normalized()));
  const double farther = to_lamp.norm() / lamp.distance_m;
  return 0.5 * (0.34 + 0.14 * normal.z() + lamp.brightness * slope / (farther * farther));
}

/// The linear light of a code.
double light_of(std::uint8_t code) {
  const double s = code / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

/// A surface that is lit all over has no shadow of its own on it, however it is turned.
TEST(Renderer, APlaneInTheLightHasTheLightOfLambertAllOver) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(-1, 1);
  const scene::Camera camera = plain_camera();
  const Mesh plane = ground_mesh();
  for (int round = 0; round < 12; ++round) {
    const Lamp above{.p_W = {0.9 * share(random), 0.9 * share(random), 2.6},
                     .radius_m = 0.08,
                     .brightness = 0.6F};
    Placement placed = at(plane, {0, 0, 0.1 * share(random)});
    placed.X_W.rotate(Eigen::AngleAxisd(
        0.7 * share(random), Eigen::Vector3d(share(random), share(random), 0.1).normalized()));
    Renderer renderer(camera, {above}, 1);
    renderer.draw({placed}, 1);
    const Eigen::Vector3d normal = placed.X_W.linear().col(2);
    const Picture<float> depth = renderer.depth();
    for (int y = 0; y < camera.lens.height_px; y += 3) {
      for (int x = 0; x < camera.lens.width_px; x += 3) {
        if (!(*depth.at(x, y) > 0)) continue;
        const Eigen::Vector3d p = camera.X_PC.p + *depth.at(x, y) * ray(camera, x, y);
        ASSERT_NEAR(light_of(*renderer.rgb().at(x, y)),
                    std::min(1.0, camera.exposure * lambert(above, p, normal)), 8e-3)
            << "round " << round << " at " << x << ", " << y;
      }
    }
  }
}

TEST(Renderer, ASphereIsShadedByItsOwnNormals) {
  const scene::Camera camera = plain_camera();
  const double radius = 0.2;
  const Mesh sphere = sphere_mesh(radius);
  const Lamp above{.p_W = {0.3, -0.2, 2.5}, .radius_m = 0.02, .brightness = 0.6F};
  Renderer renderer(camera, {above}, 1);
  const Eigen::Vector3d middle(0.05, -0.03, 0.3);
  renderer.draw({at(sphere, middle)}, 1);
  const Picture<float> depth = renderer.depth();
  int seen = 0;
  for (int y = 0; y < camera.lens.height_px; ++y) {
    for (int x = 0; x < camera.lens.width_px; ++x) {
      if (!(*depth.at(x, y) > 0)) continue;
      const Eigen::Vector3d p = camera.X_PC.p + *depth.at(x, y) * ray(camera, x, y);
      const Eigen::Vector3d normal = (p - middle) / radius;
      // Its terminator is in its own penumbra.
      if (normal.dot((above.p_W - p).normalized()) < 0.3) continue;
      ++seen;
      ASSERT_NEAR(light_of(*renderer.rgb().at(x, y)),
                  std::min(1.0, camera.exposure * lambert(above, p, normal)), 8e-3)
          << "at " << x << ", " << y;
    }
  }
  EXPECT_GT(seen, 10000);
}

TEST(Renderer, APictureOfAMovingCameraDependsOnTheStateAlone) {
  const Mesh gear = gear_mesh(gear_type(), 0xff0000), ground = ground_mesh();
  std::vector<Placement> placements = {at(ground, {0, 0, 0}), at(gear, {0.1, 0, 0.3}),
                                       at(gear, {-0.2, 0, 0.05})};
  scene::Camera camera = overhead_camera();
  camera.carrier = 0;
  camera.dirt = {{.share = 0.5, .spots = 4, .size = 0.05}};
  const Eigen::AlignedBox3d cell(Eigen::Vector3d(-1, -1, 0), Eigen::Vector3d(1, 1, 0.5));
  Eigen::Isometry3d X_WC = camera.X_PC.isometry();
  Renderer moved(camera, {lamp()}, 1, cell);
  std::vector<std::uint8_t> before;
  for (std::uint64_t frame = 1; frame <= 6; ++frame) {
    if (frame % 2 == 0) {
      X_WC.translation().x() += 0.03;
      X_WC.rotate(Eigen::AngleAxisd(0.05, Eigen::Vector3d(1, 1, 0).normalized()));
      EXPECT_TRUE(moved.set_camera(camera, X_WC, 0));
    } else {
      placements[1].X_W.translation().x() += 0.02;
      EXPECT_FALSE(moved.set_camera(camera, X_WC, 0));
    }
    const std::size_t tiles = moved.draw(placements, frame).value();
    EXPECT_EQ(tiles == moved.tiles(), frame == 1 || frame % 2 == 0);
    Renderer fresh(camera, {lamp()}, 1, cell);
    fresh.set_camera(camera, X_WC, 0);
    fresh.draw(placements, frame, 2);
    ASSERT_EQ(moved.rgb().values, fresh.rgb().values) << "frame " << frame;
    ASSERT_EQ(moved.depth().values, fresh.depth().values) << "frame " << frame;
    ASSERT_EQ(moved.normals().values, fresh.normals().values) << "frame " << frame;
    EXPECT_NE(moved.rgb().values, before);
    before = moved.rgb().values;
  }
}

TEST(Renderer, FlawsOfTheCameraChangeThePictureAndEnd) {
  const Mesh ground = ground_mesh();
  const std::vector<Placement> placements = {at(ground, {0, 0, 0})};
  const scene::Camera camera = overhead_camera();
  const Eigen::Isometry3d X_WC = camera.X_PC.isometry();
  Renderer renderer(camera, {lamp()}, 1);
  renderer.draw(placements, 1);
  const std::vector<std::uint8_t> clean = renderer.rgb().values;
  scene::Camera dirty = camera;
  dirty.dirt = {{.share = 0.5, .spots = 4, .size = 0.05}};
  EXPECT_TRUE(renderer.set_camera(dirty, X_WC, 0));
  EXPECT_EQ(renderer.draw(placements, 1).value(), 0U) << "nothing is drawn again for it";
  EXPECT_NE(renderer.rgb().values, clean);
  EXPECT_TRUE(renderer.set_camera(camera, X_WC, 0));
  renderer.draw(placements, 1);
  EXPECT_EQ(renderer.rgb().values, clean);
}

TEST(Renderer, WhatExceedsTheLimitOfMemoryIsRefused) {
  const Mesh gear = gear_mesh(gear_type(), 0xff0000), ground = ground_mesh();
  std::vector<Placement> placements = {at(ground, {0, 0, 0})};
  const scene::Camera camera = overhead_camera();
  Renderer renderer(camera, {lamp()}, 1);
  const std::uint64_t fixed = renderer.bytes();
  EXPECT_EQ(fixed, Renderer::fixed_bytes(camera));
  renderer.set_limit(fixed + (std::uint64_t{4} << 20U));
  ASSERT_TRUE(renderer.draw(placements, 1));
  EXPECT_GT(renderer.bytes(), fixed);
  for (int i = 0; i < 400; ++i) {
    placements.push_back(at(gear, {0.001 * i, 0, 0.02 + 0.001 * i}));
  }
  const auto refused = renderer.draw(placements, 2);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kFailedPrecondition);
  EXPECT_LE(renderer.bytes(), fixed + (std::uint64_t{4} << 20U));
  Renderer other(camera, {lamp()}, 1);
  other.set_limit(std::uint64_t{1} << 30U);
  EXPECT_TRUE(other.draw(placements, 2));
}

}  // namespace
}  // namespace aprsim::render
