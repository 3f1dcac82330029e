#include "world/physics/contacts/part_collider.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>
#include <variant>

namespace aprsim::physics {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

using Pieces = std::span<const ConvexPiece>;

/// Leaves out contacts from `first` on whose surface, of a piece of the body, is inside another
/// piece: nothing can be there. `outward`: 1 where the normals point out of the body.
void drop_covered(Pieces pieces, std::size_t own, const Isometry3d& X_WB, double outward,
                  std::size_t first, std::vector<Contact>& out) {
  constexpr double kBeyond = 1e-5;  // [m] over the surface
  if (pieces.size() == 1 || out.size() == first) return;
  const auto begin = out.begin() + static_cast<std::ptrdiff_t>(first);
  const auto is_covered = [&](const Contact& contact) {
    const Vector3d over =
        contact.p_W + outward * (std::max(0.0, contact.depth_m) + kBeyond) * contact.n_W;
    const Vector3d over_B = X_WB.inverse(Eigen::Isometry) * over;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (i == own) continue;
      const Vector3d over_P = pieces[i].X_BP().inverse(Eigen::Isometry) * over_B;
      if (pieces[i].nearness(over_P).distance < 0) return true;
    }
    return false;
  };
  out.erase(std::remove_if(begin, out.end(), is_covered), out.end());
}

/// A round piece turned about its axis. The four points of a level rim begin at the frame's x: it
/// tips downhill, and is held there by the whole radius.
Isometry3d turned_downhill(const Isometry3d& X_WP) {
  constexpr double kLevel = 1e-3;  // sine
  const Vector3d u = X_WP.linear().col(2);
  const Vector3d across = u.z() * u - Vector3d::UnitZ();
  const double sine = across.norm();
  if (sine < kLevel) return X_WP;
  Isometry3d X = X_WP;
  X.linear().col(0) = across / sine;
  X.linear().col(1) = u.cross(X.linear().col(0));
  return X;
}

/// Calls generate(shape, pose) for each piece whose bounds meet the box, and leaves out what other
/// pieces cover.
template <class Generate>
void for_pieces(Pieces pieces, const Isometry3d& X_WB, const Aabb& box, double outward,
                std::vector<Contact>& out, const Generate& generate) {
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Isometry3d X_WP = X_WB * pieces[i].X_BP();
    if (!pieces[i].bounds(X_WP).meets(box)) continue;
    const std::size_t first = out.size();
    const ConvexShape shape = pieces[i].shape();
    generate(shape, shape.kind == ConvexKind::kRound ? turned_downhill(X_WP) : X_WP);
    drop_covered(pieces, i, X_WB, outward, first, out);
  }
}

struct LinkShape {
  detail::GearShape& round;
  ConvexShape operator()(const robot::BoxShape& box) const { return box_shape(box.size); }
  ConvexShape operator()(const robot::CylinderShape& cylinder) const {
    const double half = 0.5 * cylinder.length_m;
    round = detail::frustum_shape(-half, cylinder.radius_m, half, cylinder.radius_m);
    return round_shape(round);
  }
  ConvexShape operator()(const robot::CapsuleShape& capsule) const {
    return capsule_shape(capsule.radius_m, 0.5 * capsule.length_m);
  }
  ConvexShape operator()(const robot::SphereShape& sphere) const {
    return capsule_shape(sphere.radius_m, 0);
  }
};

/// Bounds of a shape, as of the box around it.
Aabb bounds_of_shape(const ConvexShape& shape, const Isometry3d& X_WS) {
  if (shape.round == nullptr) return aabb_of_box(shape.size, X_WS);
  return aabb_of_box(shape.size, X_WS * Eigen::Translation3d(shape.round->middle()));
}

}  // namespace

ConvexShape shape_of_link(const ArmShape& link, detail::GearShape& round) {
  return std::visit(LinkShape{round}, link.shape);
}

void free_on_shape(const FreeBody& body, const Isometry3d& X_WB, const ConvexShape& shape,
                   const Isometry3d& X_WS, const ContactSides& sides, std::vector<Contact>& out) {
  const std::size_t first = out.size();
  if (body.is_tool()) {
    for (const scene::Block& block : body.tool->blocks()) {
      shape_on_shape(box_shape(block.size), X_WB * Eigen::Translation3d(block.centre), shape, X_WS,
                     sides, out);
    }
  } else if (body.is_tray()) {
    shape_on_tray(shape, X_WS, *body.tray, X_WB, {sides.b, sides.a, sides.pair}, out);
    for (std::size_t i = first; i < out.size(); ++i) {
      std::swap(out[i].a, out[i].b);
      out[i].n_W = -out[i].n_W;
    }
  } else {
    shape_on_shape(round_shape(body.gear_shape), X_WB, shape, X_WS, sides, out);
  }
}

void PartCollider::on_free(int part, const Isometry3d& X_WB, int other_index,
                           std::vector<Contact>& out) const {
  const FreeBody& own = model_.body(part);
  const FreeBody& other = model_.body(other_index);
  const std::size_t first = out.size();
  const ContactSides sides{part, other_index, SurfacePair::kPart};
  const Pieces pieces = own.part->pieces;
  for_pieces(
      pieces, X_WB, other.bounds, -1, out, [&](const ConvexShape& shape, const Isometry3d& X_WP) {
        if (other.is_part()) {
          const Pieces others = other.part->pieces;
          for_pieces(others, other.X_WB, bounds_of_shape(shape, X_WP), 1, out,
                     [&](const ConvexShape& of_other, const Isometry3d& X_WO) {
                       shape_on_shape(shape, X_WP, of_other, X_WO, sides, out);
                     });
        } else if (other.is_tray()) {
          shape_on_tray(shape, X_WP, *other.tray, other.X_WB, sides, out);
        } else if (other.is_tool()) {
          for (const scene::Block& block : other.tool->blocks()) {
            shape_on_shape(shape, X_WP, box_shape(block.size), other.X_WS(block), sides, out);
          }
        } else {
          shape_on_shape(shape, X_WP, round_shape(other.gear_shape), other.X_WB, sides, out);
        }
      });
  reduce_planes(first, out);
}

void PartCollider::on_fixed(int part, const Isometry3d& X_WB, const StaticShape& shape,
                            std::vector<Contact>& out) const {
  const std::size_t first = out.size();
  const ContactSides sides{part, kGround, SurfacePair::kPart};
  for_pieces(model_.body(part).part->pieces, X_WB, shape.bounds, -1, out,
             [&](const ConvexShape& own, const Isometry3d& X_WP) {
               shape_on_shape(own, X_WP, shape.shape(), shape.X_WS, sides, out);
             });
  reduce_planes(first, out);
}

void PartCollider::shape_on_part(const ConvexShape& shape, const Isometry3d& X_WS, int part,
                                 const ContactSides& sides, std::vector<Contact>& out) const {
  const FreeBody& body = model_.body(part);
  const std::size_t first = out.size();
  for_pieces(body.part->pieces, body.X_WB, bounds_of_shape(shape, X_WS), 1, out,
             [&](const ConvexShape& own, const Isometry3d& X_WP) {
               shape_on_shape(shape, X_WS, own, X_WP, sides, out);
             });
  reduce_planes(first, out);
}

void PartCollider::pad_on_part(const Pad& pad, const Isometry3d& X_WD, int part,
                               const ContactSides& sides, std::vector<Contact>& out) const {
  if (pad.shape == scene::PadShape::kFlat) {
    const Isometry3d X_WS = X_WD * Eigen::Translation3d(0, -0.5 * pad.depth_m, 0.5 * pad.height_m);
    return shape_on_part(box_shape({pad.width_m, pad.depth_m, pad.height_m}), X_WS, part, sides,
                         out);
  }
  // Without a depth of its own the groove is as deep as width and thickness allow.
  const double groove = v_groove_depth(pad, std::numeric_limits<double>::max());
  const std::size_t first = out.size();
  for (const double side : {1.0, -1.0}) {
    const detail::Prism half = half_v_pad(pad, groove, side);
    ConvexShape shape;
    shape.kind = ConvexKind::kPrism;
    // Around the origin of the pad's frame.
    shape.size = 2 * Vector3d(0.5 * pad.width_m, pad.depth_m, pad.height_m);
    shape.prism = &half;
    shape_on_part(shape, X_WD, part, sides, out);
  }
  reduce_planes(first, out);
}

}  // namespace aprsim::physics
