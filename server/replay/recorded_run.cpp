#include "server/replay/recorded_run.hpp"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "proto/journal/journal_place.hpp"
#include "proto/journal/journal_reader.hpp"
#include "server/journal/digest.hpp"
#include "server/journal/run_header.hpp"
#include "server/replay/replay.hpp"
#include "world/cell/state_bytes.hpp"
#include "world/devices/device_group.hpp"
#include "world/devices/extension.hpp"
#include "world/scene/data_paths.hpp"

namespace aprsim::server::journal {
namespace {

/// A temporary directory for the models of a journal, removed with its last owner.
std::shared_ptr<const std::string> model_directory() {
  std::string name = (std::filesystem::temp_directory_path() / "aprsim-replay-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) name.clear();
  return {new std::string(name), [](const std::string* path) {
            std::error_code ignored;
            if (!path->empty()) std::filesystem::remove_all(*path, ignored);
            delete path;
          }};
}

template <typename Number>
bool whole(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

/// Extensions that are not the recorded ones.
void add_cautions_of_extensions(const v1::JournalHeader& header, std::vector<std::string>& all) {
  const std::vector<std::string> directories = scene::default_data_paths().extensions;
  for (const v1::JournalFile& extension : header.extensions()) {
    const std::string file = devices::find_extension(extension.name(), directories);
    std::ifstream in(file, std::ios::binary);
    const std::string digest = sha256(std::string(std::istreambuf_iterator<char>(in), {}));
    if (digest == extension.sha256()) continue;
    all.push_back(
        fmt::format("the extension {} was recorded with the digest {:.12} and has {:.12} here: its "
                    "devices may behave differently",
                    extension.name(), extension.sha256(), digest));
  }
}

world::RunTime of(const v1::JournalTime& time) { return {time.epoch(), time.step()}; }

}  // namespace

Result<RunMoment> to_run_moment(const std::string& text) {
  RunMoment moment;
  const auto colon = text.find(':');
  bool good = true;
  if (colon != std::string::npos) {
    good = whole(std::string_view(text).substr(0, colon), moment.epoch.emplace());
  }
  const auto seconds = std::string_view(text).substr(colon == std::string::npos ? 0 : colon + 1);
  good = good && whole(seconds, moment.seconds) && std::isfinite(moment.seconds) &&
         moment.seconds >= 0 && moment.seconds < 1e9;
  if (!good) {
    return fail(ErrorCode::kInvalidArgument, "time",
                "'" + text + "' is neither SECONDS nor EPOCH:SECONDS");
  }
  return moment;
}

std::optional<world::RunTime> time_of(const v1::JournalRecord& record) {
  switch (record.record_case()) {
    case v1::JournalRecord::kEpoch:
      return of(record.epoch().time());
    case v1::JournalRecord::kCommand:
      return of(record.command().time());
    case v1::JournalRecord::kState:
      return of(record.state().time());
    case v1::JournalRecord::kCheckpoint:
      return of(record.checkpoint().time());
    default:
      return std::nullopt;
  }
}

Result<RecordedRun> RecordedRun::open(const std::vector<std::string>& places,
                                      const std::string& version) {
  RecordedRun run;
  run.files_ = places;
  if (places.size() == 1) {
    auto files = aprsim::journal::files_of_run(places.front());
    if (!files) return tl::unexpected(files.error());
    run.files_ = *std::move(files);
  }
  run.models_ = model_directory();
  for (const std::string& file : run.files_) {
    auto reader = aprsim::journal::JournalReader::open(file);
    if (!reader) return tl::unexpected(reader.error());
    if (file == run.files_.front()) {
      run.header_ = reader->header();
    } else if (reader->header().run_id() != run.header_.run_id()) {
      return fail(ErrorCode::kInvalidArgument, "journal",
                  fmt::format("{}: of run {}, and {} is of run {}", file, reader->header().run_id(),
                              run.files_.front(), run.header_.run_id()));
    }
  }
  auto scene = scene_of(run.header_, *run.models_);
  if (!scene) {
    return fail(scene.error().code, scene.error().field,
                run.files_.front() + ": " + scene.error().message);
  }
  if (auto ok = devices::check_devices(*scene, "recorded scene"); !ok) {
    return fail(ok.error().code, ok.error().field,
                run.files_.front() + ": it cannot be replayed here: " + ok.error().message);
  }
  run.scene_ = std::make_shared<const scene::Scene>(std::move(*scene));
  v1::JournalHeader here = header_here();
  here.set_version(version);
  run.cautions_ = journal::cautions(run.header_, here);
  add_cautions_of_extensions(run.header_, run.cautions_);
  if (!run.has_checkpoints()) {
    run.cautions_.push_back(
        fmt::format("its checkpoints have layout {}, this program has {}: it is replayed from its "
                    "start, but not "
                    "after a state was loaded",
                    run.header_.state_version(), world::kStateVersion));
  }
  return run;
}

bool RecordedRun::has_checkpoints() const {
  return header_.state_version() == world::kStateVersion;
}

Result<std::string> RecordedRun::each(const Take& take) const {
  std::string damage;
  for (const std::string& file : files_) {
    auto reader = aprsim::journal::JournalReader::open(file);
    if (!reader) return tl::unexpected(reader.error());
    for (v1::JournalRecord record; reader->next(record);) {
      const auto goes_on = take(record);
      if (!goes_on) {
        return fail(goes_on.error().code, goes_on.error().field,
                    file + ": " + goes_on.error().message);
      }
      if (!*goes_on) return damage;
    }
    if (!reader->damage().empty()) damage = file + ": " + reader->damage();
  }
  return damage;
}

Result<world::RunTime> RecordedRun::time_of(const RunMoment& moment) const {
  std::optional<world::RunTime> found;
  const auto read = each([&](const v1::JournalRecord& record) -> Result<bool> {
    const auto time = journal::time_of(record);
    if (!time || (moment.epoch && time->epoch != *moment.epoch)) return true;
    found = {time->epoch,
             static_cast<std::uint64_t>(std::llround(moment.seconds / scene_->physics.step_s))};
    return false;
  });
  if (!read) return tl::unexpected(read.error());
  if (!found) {
    return fail(ErrorCode::kInvalidArgument, "time",
                moment.epoch ? fmt::format("epoch {} is not recorded", *moment.epoch)
                             : "nothing is recorded");
  }
  return *found;
}

Result<std::uint64_t> RecordedRun::checkpoint_before(world::RunTime time) const {
  std::uint64_t number = 0, found = 0;
  const auto read = each([&](const v1::JournalRecord& record) -> Result<bool> {
    const auto at = journal::time_of(record);
    if (at && *at > time) return false;
    if (record.has_checkpoint()) found = number;
    ++number;
    return true;
  });
  if (!read) return tl::unexpected(read.error());
  return found;
}

}  // namespace aprsim::server::journal
