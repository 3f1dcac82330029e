#include "world/render/cell/piece_meshes.hpp"

#include <cmath>
#include <numbers>
#include <variant>

#include "world/render/cell/palette.hpp"

namespace aprsim::render {
namespace {

constexpr int kAround = 48, kCapSteps = 8;

struct PieceAdder {
  MeshBuilder& mesh;

  void operator()(const api::BoxPiece& box) const { mesh.box(Eigen::Vector3d::Zero(), box.size); }
  void operator()(const api::ConePiece& cone) const {
    const double half = cone.height_m / 2;
    mesh.lathe({{0, -half}, {cone.bottom_radius_m, -half}, {cone.top_radius_m, half}, {0, half}},
               kAround);
  }
  void operator()(const api::CapsulePiece& capsule) const {
    if (capsule.length_m == 0) return mesh.sphere(capsule.radius_m, kAround);
    std::vector<Eigen::Vector2d> profile;
    for (const double end : {-1.0, 1.0}) {
      for (int i = 0; i <= kCapSteps; ++i) {
        const double turn =
            std::numbers::pi / 2 * (static_cast<double>(i) / kCapSteps - (end < 0 ? 1 : 0));
        const bool pole = end < 0 ? i == 0 : i == kCapSteps;
        profile.emplace_back(pole ? 0 : capsule.radius_m * std::cos(turn),
                             end * capsule.length_m / 2 + capsule.radius_m * std::sin(turn));
      }
    }
    mesh.lathe(profile, kAround);
  }
  void operator()(const api::PrismPiece& prism) const {
    const double half = prism.height_m / 2;
    mesh.walls(prism.corners, -half, half);
    mesh.face(prism.corners, {}, -half, false);
    mesh.face(prism.corners, {}, half, true);
  }
  void operator()(const api::HullPiece& hull) const {
    const auto at = [&hull](int i) { return hull.corners[static_cast<std::size_t>(i)]; };
    for (const auto& face : hull.faces) {
      for (std::size_t k = 1; k + 1 < face.size(); ++k) {
        mesh.triangle(at(face[0]), at(face[k]), at(face[k + 1]));
      }
    }
  }
};

}  // namespace

Mesh pieces_mesh(std::span<const api::Piece> pieces, std::uint32_t colour) {
  MeshBuilder mesh;
  mesh.set_material(paint(colour, 0.08F));
  for (const api::Piece& piece : pieces) {
    mesh.set_frame(piece.X_BP.isometry());
    std::visit(PieceAdder{mesh}, piece.shape);
  }
  return mesh.take();
}

}  // namespace aprsim::render
