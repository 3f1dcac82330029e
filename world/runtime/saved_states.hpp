#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"
#include "world/cell/world_state.hpp"
#include "world/robot/trajectory/profile/shared_parts.hpp"

namespace aprsim::world {

/// The states that are saved under names: at most api::kMaxSavedStates, and bounded in bytes.
/// Thread: sim.
class SavedStates {
 public:
  explicit SavedStates(std::uint64_t max_bytes);

  /// Saves a state in place of one of this name; without memory nothing changes. Errors:
  /// kFailedPrecondition when there are too many or they are too large.
  [[nodiscard]] Result<void> keep(const std::string& name, api::StatePtr state, SimTime step_size);
  /// Errors: kNotFound.
  [[nodiscard]] Result<void> forget(const std::string& name);
  /// Null when none has the name.
  [[nodiscard]] api::StatePtr find(const std::string& name) const;
  /// Never null.
  [[nodiscard]] const std::shared_ptr<const api::SavedStates>& list() const { return list_; }

 private:
  struct Saved {
    api::StatePtr state;
    SimTime time{};
    std::uint64_t own_bytes = 0;
    robot::SharedParts shared;
  };
  using Entries = std::map<std::string, Saved>;
  /// The list as it is with `more` in place of what has its name, or without that.
  [[nodiscard]] std::shared_ptr<const api::SavedStates> list_with(const std::string& name,
                                                                  const Saved* more) const;

  std::uint64_t max_bytes_;
  Entries entries_;
  std::shared_ptr<const api::SavedStates> list_;
};

}  // namespace aprsim::world
