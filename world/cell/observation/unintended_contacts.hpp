#pragma once

#include <cstdint>
#include <span>

#include "world/api/snapshot/snapshot.hpp"
#include "world/physics/contacts/arm_force.hpp"
#include "world/scene/model/free_body.hpp"

namespace aprsim::world {

/// Records contacts of robots that belong to no work: all but those of a gripper with gears and
/// with the body that it holds. Contacts of one pair count as one if they are less than
/// kSameContactSteps apart. A copyable value. Thread: one at a time.
class UnintendedContacts {
 public:
  static constexpr std::uint64_t kSameContactSteps = 250;

  /// Adds the forces on a robot's arm after a step. Those of a gripper count if it `has_tool`;
  /// `bodies` are the cell's, by index.
  void add(std::uint64_t step, int robot, std::span<const physics::ArmForce> forces, bool has_tool,
           std::span<const scene::FreeBody> bodies);
  [[nodiscard]] const api::UnintendedContactsPtr& list() const { return list_; }
  /// Renumbers bodies: `new_of` has the new number of each old one.
  void renumber(std::span<const int> new_of);

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [list] = self;
    io(list);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(!list_ || list_->size() <= api::kMaxUnintendedContacts,
               "more contacts than are kept");
  }

 private:
  api::UnintendedContactsPtr list_;
};

}  // namespace aprsim::world
