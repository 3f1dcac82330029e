#include "server/journal/replay_files.hpp"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace aprsim::server::journal {

Result<ReplayResult> replay_run(const RecordedRun& run, const ReplayPart& part) {
  Replay replay(run.header(), run.scene());
  replay.watch(part.watch);
  if (part.to) {
    const auto to = run.time_of(*part.to);
    if (!to) return tl::unexpected(to.error());
    replay.end_at(*to);
  }
  std::uint64_t first = 0;
  if (part.from) {
    const auto from = run.time_of(*part.from);
    if (!from) return tl::unexpected(from.error());
    if (run.has_checkpoints()) {
      const auto checkpoint = run.checkpoint_before(*from);
      if (!checkpoint) return tl::unexpected(checkpoint.error());
      first = *checkpoint;
    }
  }
  std::uint64_t number = 0;
  const auto damage = run.each([&](const v1::JournalRecord& record) -> Result<bool> {
    if (part.hear) part.hear(record);
    if (number++ < first) return true;
    return replay.take(record);
  });
  if (!damage) return tl::unexpected(damage.error());
  if (auto done = replay.finish(); !done) return tl::unexpected(done.error());
  ReplayResult result = replay.result();
  result.damage = *damage;
  return result;
}

std::string text_of(const RecordedRun& run, const ReplayResult& result) {
  std::string text = fmt::format(
      "run {} of scene {}, seed {}: {} steps, {} commands, {} states "
      "compared\n",
      run.header().run_id(), run.header().scene(), run.header().seed(), result.steps,
      result.commands, result.compared);
  for (const std::string& caution : run.cautions()) text += "caution: " + caution + '\n';
  if (result.missing > 0) {
    text +=
        fmt::format("{} records are missing in gaps that the journal tells of\n", result.missing);
  }
  if (result.gaps > 0) {
    text += fmt::format(
        "{} of these gaps lack commands: gone on from the checkpoint behind each, where there is "
        "one\n",
        result.gaps);
  }
  if (!result.damage.empty()) text += "the journal ends early: " + result.damage + '\n';
  if (!result.difference) {
    return text + (result.compared > 0 ? "all states are the same\n" : "no state to compare\n");
  }
  return text + fmt::format("differs at step {} of epoch {}: {}\n", result.difference->time.step,
                            result.difference->time.epoch, result.difference->what);
}

std::string json_of(const RecordedRun& run, const ReplayResult& result) {
  nlohmann::ordered_json object{{"run_id", run.header().run_id()}, {"scene", run.header().scene()},
                                {"seed", run.header().seed()},     {"cautions", run.cautions()},
                                {"steps", result.steps},           {"commands", result.commands},
                                {"compared", result.compared},     {"gaps", result.gaps},
                                {"missing", result.missing},       {"damage", result.damage},
                                {"same", !result.difference},      {"difference", nullptr}};
  if (result.difference) {
    object["difference"] = {{"epoch", result.difference->time.epoch},
                            {"step", result.difference->time.step},
                            {"what", result.difference->what}};
  }
  return object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace aprsim::server::journal
