#include "world/runtime/saved_states.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "world/api/commands/simulation_command.hpp"

namespace aprsim::world {
namespace {

/// In MB, as the configuration has it.
std::string megabytes(std::uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", static_cast<double>(bytes) / (1U << 20U));
  return text;
}

}  // namespace

SavedStates::SavedStates(std::uint64_t max_bytes)
    : max_bytes_(max_bytes),
      list_(std::make_shared<const api::SavedStates>(api::SavedStates{.max_bytes = max_bytes})) {}

Result<void> SavedStates::keep(const std::string& name, api::StatePtr state, SimTime step_size) {
  if (!entries_.contains(name) && entries_.size() >= api::kMaxSavedStates) {
    return fail(ErrorCode::kFailedPrecondition, "name",
                "'" + name + "' cannot be saved: all " + std::to_string(api::kMaxSavedStates) +
                    " places for saved states are taken; use one of their names again, or delete "
                    "one");
  }
  const SimTime time = step_size * static_cast<SimTime::rep>(state->steps);
  Saved more{std::move(state), time, 0, {}};
  more.own_bytes = more.state->bytes();
  more.state->list(more.shared);
  auto list = list_with(name, &more);
  if (list->bytes > max_bytes_) {
    return fail(ErrorCode::kFailedPrecondition, "name",
                "'" + name + "' cannot be saved: the saved states would take " +
                    megabytes(list->bytes) + " MB, the limit is " + megabytes(max_bytes_) +
                    " MB; delete one, or set memory.saved_states_mb");
  }
  entries_.insert_or_assign(name, std::move(more));
  list_ = std::move(list);
  return {};
}

Result<void> SavedStates::forget(const std::string& name) {
  const auto found = entries_.find(name);
  if (found == entries_.end()) {
    return fail(ErrorCode::kNotFound, "name", "no state is saved as '" + name + "'");
  }
  auto list = list_with(name, nullptr);
  entries_.erase(found);
  list_ = std::move(list);
  return {};
}

api::StatePtr SavedStates::find(const std::string& name) const {
  const auto found = entries_.find(name);
  return found == entries_.end() ? nullptr : found->second.state;
}

std::shared_ptr<const api::SavedStates> SavedStates::list_with(const std::string& name,
                                                               const Saved* more) const {
  api::SavedStates list{.max_bytes = max_bytes_};
  robot::SharedParts all;
  const auto add = [&](const std::string& of, const Saved& saved) {
    list.states.push_back({of, saved.own_bytes + robot::bytes_of(saved.shared), saved.state->steps,
                           saved.time, saved.state});
    list.bytes += saved.own_bytes;
    all.insert(saved.shared.begin(), saved.shared.end());
  };
  for (const auto& [of, saved] : entries_) {
    if (of != name) add(of, saved);
  }
  if (more != nullptr) add(name, *more);
  std::ranges::sort(list.states, {}, &api::SavedState::name);
  list.bytes += robot::bytes_of(all);
  return std::make_shared<const api::SavedStates>(std::move(list));
}

}  // namespace aprsim::world
