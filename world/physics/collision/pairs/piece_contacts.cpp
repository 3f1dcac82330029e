#include "world/physics/collision/pairs/piece_contacts.hpp"

#include <span>
#include <utility>

#include "world/physics/collision/pairs/capsule_contacts.hpp"
#include "world/physics/collision/pairs/cone_sides.hpp"
#include "world/physics/collision/pairs/gear_vs_prism.hpp"
#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/pairs/pocket_contacts.hpp"
#include "world/physics/collision/pairs/polytope_contacts.hpp"

namespace aprsim::physics {
namespace {

using detail::Candidates;
using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Sets bodies and surfaces of the contacts from `first` on, which were found with a and b swapped.
void turn_round(std::size_t first, const ContactSides& sides, std::vector<Contact>& out) {
  for (std::size_t i = first; i < out.size(); ++i) {
    out[i].a = sides.a;
    out[i].b = sides.b;
    out[i].n_W = -out[i].n_W;
  }
}

ContactSides swapped(const ContactSides& sides) { return {sides.b, sides.a, sides.pair}; }

/// The polyhedron of a box or prism that has none: `work` becomes it.
const detail::Polytope& polytope_of(const ConvexShape& shape, detail::Polytope& work) {
  if (shape.polytope != nullptr) return *shape.polytope;
  work.set_prism(shape.prism != nullptr ? *shape.prism
                                        : detail::box_prism(-0.5 * shape.size, 0.5 * shape.size));
  return work;
}

void flat_on_flat(const ConvexShape& a, const Isometry3d& X_WA, const ConvexShape& b,
                  const Isometry3d& X_WB, const ContactSides& sides, std::vector<Contact>& out) {
  if (a.kind == ConvexKind::kBox && b.kind == ConvexKind::kBox) {
    return box_box(a.size, X_WA, b.size, X_WB, sides.a, sides.b, sides.pair, out);
  }
  thread_local detail::Polytope work_a, work_b;
  Candidates points;
  detail::polytope_on_polytope(polytope_of(a, work_a), X_WB.inverse(Eigen::Isometry) * X_WA,
                               polytope_of(b, work_b), points);
  detail::emit_reduced(points, {X_WB, sides.a, sides.b, sides.pair, out, false, true});
}

void round_on_flat(const detail::GearShape& a, const Isometry3d& X_WA, const ConvexShape& b,
                   const Isometry3d& X_WB, const ContactSides& sides, std::vector<Contact>& out) {
  if (b.kind == ConvexKind::kBox) {
    return gear_box(a, X_WA, b.size, X_WB, sides.a, sides.b, sides.pair, out);
  }
  const Isometry3d X_BA = X_WB.inverse(Eigen::Isometry) * X_WA;
  Candidates points;
  const bool near = b.prism != nullptr ? detail::gear_on_prism(a, X_BA, *b.prism, {}, points)
                                       : detail::gear_on_polytope(a, X_BA, *b.polytope, points);
  if (!near) return;
  detail::emit_reduced_by_axis(points, X_BA.linear().col(2),
                               {X_WB, sides.a, sides.b, sides.pair, out});
}

/// Sides of cones that cross, which gear_gear() finds of cylinders only.
void cones_across(const detail::GearShape& a, const Isometry3d& X_WA, const detail::GearShape& b,
                  const Isometry3d& X_WB, const ContactSides& sides, std::vector<Contact>& out) {
  const Isometry3d X_BA = X_WB.inverse(Eigen::Isometry) * X_WA;
  Candidates points;
  for (const detail::Piece& of_a :
       std::span(a.pieces).first(static_cast<std::size_t>(a.piece_count))) {
    for (const detail::Piece& of_b :
         std::span(b.pieces).first(static_cast<std::size_t>(b.piece_count))) {
      if (of_a.slope != 0 || of_b.slope != 0) detail::crossing_cones(of_a, X_BA, of_b, points);
    }
  }
  detail::emit_reduced(points, {X_WB, sides.a, sides.b, sides.pair, out});
}

/// Contacts of a capsule with one gear are those of its pieces, without those inside other pieces.
void capsule_on_round(const detail::Segment& segment, double radius_m,
                      const detail::GearShape& round, Candidates& out) {
  constexpr double kOutside = 1e-6;  // [m]
  for (int i = 0; i < round.piece_count; ++i) {
    Candidates found;
    const detail::Piece& piece = round.pieces[static_cast<std::size_t>(i)];
    detail::capsule_on(
        segment, radius_m, [&piece](const Vector3d& p) { return detail::nearness(piece, p); },
        found);
    for (int k = 0; k < found.size(); ++k) {
      const Vector3d surface = found[k].p + (found[k].depth + kOutside) * found[k].n;
      bool covered = false;
      for (int j = 0; j < round.piece_count; ++j) {
        covered =
            covered ||
            (j != i &&
             detail::nearness(round.pieces[static_cast<std::size_t>(j)], surface).distance < 0);
      }
      if (!covered) out.add(found[k].p, found[k].n, found[k].depth);
    }
  }
}

void capsule_on_shape(const ConvexShape& a, const Isometry3d& X_WA, const ConvexShape& b,
                      const Isometry3d& X_WB, const ContactSides& sides,
                      std::vector<Contact>& out) {
  const Isometry3d X_BA = X_WB.inverse(Eigen::Isometry) * X_WA;
  const detail::Segment segment{X_BA.translation(), a.half_length_m * X_BA.linear().col(2)};
  Candidates points;
  const auto touch = [&](const auto& near_to) {
    detail::capsule_on(segment, a.radius_m, near_to, points);
  };
  switch (b.kind) {
    case ConvexKind::kBox:
      touch([&b](const Vector3d& p) { return detail::nearness(b.size, p); });
      break;
    case ConvexKind::kPrism:
      touch([&b](const Vector3d& p) { return detail::nearness(*b.prism, p); });
      break;
    case ConvexKind::kHull:
      touch([&b](const Vector3d& p) { return detail::nearness(*b.polytope, p); });
      break;
    case ConvexKind::kRound:
      capsule_on_round(segment, a.radius_m, *b.round, points);
      break;
    case ConvexKind::kCapsule:
      touch([&b](const Vector3d& p) {
        return detail::capsule_nearness(b.radius_m, b.half_length_m, p);
      });
      break;
  }
  detail::emit_reduced(points, {X_WB, sides.a, sides.b, sides.pair, out, false, true});
}

}  // namespace

void shape_on_shape(const ConvexShape& a, const Isometry3d& X_WA, const ConvexShape& b,
                    const Isometry3d& X_WB, const ContactSides& sides, std::vector<Contact>& out) {
  const std::size_t first = out.size();
  const bool a_round = a.kind == ConvexKind::kRound, b_round = b.kind == ConvexKind::kRound;
  if (a.kind == ConvexKind::kCapsule) {
    capsule_on_shape(a, X_WA, b, X_WB, sides, out);
  } else if (b.kind == ConvexKind::kCapsule) {
    capsule_on_shape(b, X_WB, a, X_WA, swapped(sides), out);
    turn_round(first, sides, out);
  } else if (a_round && b_round) {
    gear_gear(*a.round, X_WA, *b.round, X_WB, sides.a, sides.b, out);
    cones_across(*a.round, X_WA, *b.round, X_WB, sides, out);
    for (std::size_t i = first; i < out.size(); ++i) out[i].pair = sides.pair;
  } else if (a_round) {
    round_on_flat(*a.round, X_WA, b, X_WB, sides, out);
  } else if (b_round) {
    round_on_flat(*b.round, X_WB, a, X_WA, swapped(sides), out);
    turn_round(first, sides, out);
  } else {
    flat_on_flat(a, X_WA, b, X_WB, sides, out);
  }
}

void shape_on_tray(const ConvexShape& shape, const Isometry3d& X_WS, const scene::TrayType& tray,
                   const Isometry3d& X_WP, const ContactSides& sides, std::vector<Contact>& out) {
  const std::size_t first = out.size();
  if (shape.kind == ConvexKind::kRound) {
    gear_tray(*shape.round, X_WS, tray, X_WP, sides.a, sides.b, out);
    for (std::size_t i = first; i < out.size(); ++i) out[i].pair = sides.pair;
    return;
  }
  const Isometry3d X_PS = X_WP.inverse(Eigen::Isometry) * X_WS;
  const detail::Prism slab = detail::slab_prism(tray);
  Candidates points;
  bool near_outline = false;
  if (shape.kind == ConvexKind::kCapsule) {
    const detail::Segment segment{X_PS.translation(), shape.half_length_m * X_PS.linear().col(2)};
    near_outline = detail::capsule_on_pocketed_slab(segment, shape.radius_m, slab, tray, points);
  } else {
    thread_local detail::Polytope work;
    near_outline =
        detail::polytope_on_pocketed_slab(polytope_of(shape, work), X_PS, slab, tray, points);
  }
  const detail::Emission emission{X_WP, sides.a, sides.b, sides.pair, out, false, true};
  if (near_outline) return detail::emit_reduced_by_direction(points, emission);
  detail::emit_reduced_by_axis(points, Vector3d::UnitZ(), emission);
}

void reduce_planes(std::size_t first, std::vector<Contact>& out) {
  constexpr std::size_t kFew = 8;
  constexpr double kSamePlane = 0.999;
  if (out.size() - first <= kFew) return;
  static const Isometry3d kIdentity = Isometry3d::Identity();
  thread_local std::vector<Contact> all;
  all.assign(out.begin() + static_cast<std::ptrdiff_t>(first), out.end());
  out.resize(first);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].depth_m <= 0) continue;  // taken
    Candidates plane;
    const Vector3d n_W = all[i].n_W;
    const Contact lead = all[i];
    for (std::size_t k = i; k < all.size(); ++k) {
      if (all[k].depth_m <= 0 || all[k].n_W.dot(n_W) < kSamePlane) continue;
      plane.add(all[k].p_W, all[k].n_W, all[k].depth_m);
      all[k].depth_m = 0;
    }
    detail::emit_reduced(plane, {kIdentity, lead.a, lead.b, lead.pair, out, false, true});
  }
}

}  // namespace aprsim::physics
