#include "server/replay/replay_files.hpp"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "server/replay/wire_check.hpp"

namespace aprsim::server::journal {

Result<ReplayResult> replay_run(const RecordedRun& run, const ReplayPart& part) {
  Replay replay(run.header(), run.scene(), run.directory());
  WireCheck wires(*run.scene(), part.scaling);
  replay.watch([&](const world::World& world, world::RunTime time) {
    wires.observe(world, time);
    return !part.watch || part.watch(world, time);
  });
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
    if (part.on_record) part.on_record(record);
    wires.process(record, number >= first);
    if (number++ < first) return true;
    return replay.process(record);
  });
  if (!damage) return tl::unexpected(damage.error());
  if (auto done = replay.finish(); !done) return tl::unexpected(done.error());
  wires.finish();
  ReplayResult result = replay.result();
  result.replies = wires.compared();
  result.reply = wires.difference();
  result.damage = *damage;
  return result;
}

std::string text_of(const Difference& difference) {
  return fmt::format("at step {} of epoch {}: {}\n", difference.time.step, difference.time.epoch,
                     difference.text);
}

std::string text_of(const RecordedRun& run, const ReplayResult& result) {
  std::string text = fmt::format(
      "run {} of scene {}, seed {}: {} steps, {} commands, {} states "
      "compared\n",
      run.header().run_id(), run.header().scene(), run.header().seed(), result.steps,
      result.commands, result.compared);
  for (const std::string& caution : run.cautions()) text += "caution: " + caution + '\n';
  if (result.missing > 0) {
    text += fmt::format("{} records are missing in gaps of the journal\n", result.missing);
  }
  if (result.gaps > 0) {
    text += fmt::format(
        "{} of these gaps lack commands: continued at the checkpoint after each, where there is "
        "one\n",
        result.gaps);
  }
  if (!result.damage.empty()) text += "the journal ends early: " + result.damage + '\n';
  if (result.replies > 0) {
    text += fmt::format(
        "{} replies compared: joints, poses and grippers in CRCL statuses, joints in states of "
        "Simple Message, registers read by "
        "Modbus clients, lines of cameras\n",
        result.replies);
  }
  if (result.reply) text += "another reply " + text_of(*result.reply);
  if (result.difference) return text + "differs " + text_of(*result.difference);
  return text + (result.compared > 0 ? "all states are the same\n" : "no state to compare\n");
}

std::string json_of(const RecordedRun& run, const ReplayResult& result) {
  nlohmann::ordered_json object{{"run_id", run.header().run_id()}, {"scene", run.header().scene()},
                                {"seed", run.header().seed()},     {"cautions", run.cautions()},
                                {"steps", result.steps},           {"commands", result.commands},
                                {"compared", result.compared},     {"gaps", result.gaps},
                                {"missing", result.missing},       {"damage", result.damage},
                                {"same", result.same()},           {"difference", nullptr},
                                {"replies", result.replies},       {"reply", nullptr}};
  const auto add = [&object](const char* key, const std::optional<Difference>& difference) {
    if (!difference) return;
    object[key] = {{"epoch", difference->time.epoch},
                   {"step", difference->time.step},
                   {"text", difference->text}};
  };
  add("difference", result.difference);
  add("reply", result.reply);
  return object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

}  // namespace aprsim::server::journal
