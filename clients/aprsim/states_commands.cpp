#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cell_connection.hpp"
#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/status_text.hpp"

namespace aprsim::client {
namespace {

double megabytes(std::uint64_t bytes) { return static_cast<double>(bytes) / (1U << 20U); }

}  // namespace

Outcome<void> run_command(const StatesListCommand& /*command*/, Console& console) {
  const auto listed = CellConnection(console.endpoints).list_states();
  if (!listed) return tl::unexpected(listed.error());
  std::string text;
  auto states = nlohmann::ordered_json::array();
  for (const v1::SavedState& state : listed->states()) {
    const double time_s = seconds(state.sim_time());
    text += fmt::format("{:<24} step {:>10} {:>12.3f} s {:>8.1f} MB\n", state.name(), state.step(),
                        time_s, megabytes(state.bytes()));
    states.push_back({{"name", state.name()},
                      {"step", state.step()},
                      {"sim_time_s", time_s},
                      {"bytes", state.bytes()}});
  }
  text += fmt::format("{} saved, {:.1f} of {:.0f} MB\n", listed->states_size(),
                      megabytes(listed->bytes()), megabytes(listed->max_bytes()));
  console.show(
      text, {{"states", states}, {"bytes", listed->bytes()}, {"max_bytes", listed->max_bytes()}});
  return {};
}

Outcome<void> run_command(const StatesDeleteCommand& command, Console& console) {
  const auto deleted = CellConnection(console.endpoints).delete_state(command.name);
  if (!deleted) return tl::unexpected(deleted.error());
  console.show(fmt::format("deleted '{}'\n", command.name),
               {{"done", "states delete"}, {"name", command.name}});
  return {};
}

}  // namespace aprsim::client
