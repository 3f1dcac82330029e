#pragma once

#include <string>
#include <vector>

#include "world/api/values/pose.hpp"
#include "world/scene/model/scene.hpp"

/// Bodies pressed into each other, then let go: what comes of it in each mode of simplification.
namespace aprsim::physics::test {

enum class Jam {
  kQueue,   ///< three loaded trays run into each other at a stop on the belt, which then goes back
  kWedge,   ///< a gear pinned between the closed fingers and a wall
  kCorner,  ///< a loaded tray pushed askew into a corner by the closed fingers
  kCrowd,   ///< gears swept together by the closed fingers; chaotic
  kPile,    ///< gears that fall into a narrow bin; chaotic
};
std::string name_of(Jam jam);

struct JamOutcome {
  std::vector<Pose> pressed, left;  ///< poses while jammed and at the end: trays, then gears
  std::vector<bool> resting;        ///< at the end, by body
  double deepest_m = 0;
  std::uint64_t unsolved = 0;  ///< islands over the solver's tolerance
};

/// Deliberate changes, to test the power of a comparison.
struct JamChange {
  double nudge_m = 0;         ///< gears begin so far to the side, this way and that
  double friction_share = 1;  ///< of all friction that there is
};

/// The same seed, the same beginning in all modes. Throws PhysicsFailure.
JamOutcome run_jam(Jam jam, scene::Simplification mode, unsigned seed,
                   const JamChange& change = {});

/// The farthest that any body is in one list from where it is in the other [m].
double farthest_apart(const std::vector<Pose>& a, const std::vector<Pose>& b);

}  // namespace aprsim::physics::test
