#include "server/journal/replay_files.hpp"

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "proto/journal/journal_reader.hpp"
#include "server/journal/run_header.hpp"

namespace aprsim::server::journal {
namespace {

/// For the models of a journal, gone with it.
class ModelDirectory {
 public:
  ModelDirectory() {
    std::string name = (std::filesystem::temp_directory_path() / "aprsim-replay-XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~ModelDirectory() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  ModelDirectory(const ModelDirectory&) = delete;
  ModelDirectory& operator=(const ModelDirectory&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

Result<FilesReplayed> replay_files(const std::vector<std::string>& files,
                                   const std::string& version) {
  const ModelDirectory models;
  FilesReplayed out;
  std::optional<Replay> replay;
  for (const std::string& file : files) {
    auto reader = aprsim::journal::JournalReader::open(file);
    if (!reader) return tl::unexpected(reader.error());
    if (!replay) {
      out.header = reader->header();
      auto scene = scene_of(out.header, models.path());
      if (!scene) return tl::unexpected(scene.error());
      v1::JournalHeader here = header_here();
      here.set_version(version);
      out.cautions = cautions(out.header, here);
      replay.emplace(out.header, std::make_shared<const scene::Scene>(std::move(*scene)));
    } else if (reader->header().run_id() != out.header.run_id()) {
      return fail(ErrorCode::kInvalidArgument, "journal",
                  fmt::format("{}: of run {}, and {} is of run {}", file, reader->header().run_id(),
                              files.front(), out.header.run_id()));
    }
    for (v1::JournalRecord record; reader->next(record);) {
      const auto goes_on = replay->take(record);
      if (!goes_on) {
        return fail(goes_on.error().code, goes_on.error().field,
                    file + ": " + goes_on.error().message);
      }
      if (!*goes_on) break;
    }
    out.result = replay->result();
    if (!reader->damage().empty()) out.result.damage = file + ": " + reader->damage();
    if (out.result.difference) break;
  }
  return out;
}

std::string text_of(const FilesReplayed& replayed) {
  const ReplayResult& result = replayed.result;
  std::string text = fmt::format(
      "run {} of scene {}, seed {}: {} steps, {} commands, {} states "
      "compared\n",
      replayed.header.run_id(), replayed.header.scene(), replayed.header.seed(), result.steps,
      result.commands, result.compared);
  for (const std::string& caution : replayed.cautions) text += "caution: " + caution + '\n';
  if (result.gaps > 0) {
    text += fmt::format("{} gaps, each gone on from the checkpoint behind it\n", result.gaps);
  }
  if (!result.damage.empty()) text += "the journal ends early: " + result.damage + '\n';
  if (!result.difference) {
    return text + (result.compared > 0 ? "all states are the same\n" : "no state to compare\n");
  }
  return text + fmt::format("differs at step {} of epoch {}: {}\n", result.difference->time.step,
                            result.difference->time.epoch, result.difference->what);
}

}  // namespace aprsim::server::journal
