#include "clients/aprsim/batch/batch_directory.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/batch/seeds.hpp"
#include "world/base/files/draft_file.hpp"

namespace aprsim::client {
namespace {

namespace fs = std::filesystem;
using BatchJson = nlohmann::ordered_json;

constexpr std::size_t kMostCauses = 100;
constexpr std::string_view kSeedPrefix = "seed_", kEpisodeEnding = ".json",
                           kJournalEnding = ".journal";

/// The seed of "seed_7.json".
std::optional<std::uint64_t> seed_of(const std::string& name, std::string_view ending) {
  if (!name.starts_with(kSeedPrefix) || !name.ends_with(ending)) return std::nullopt;
  const char* const begin = name.data() + kSeedPrefix.size();
  const char* const end = name.data() + name.size() - ending.size();
  std::uint64_t seed = 0;
  const auto [stop, error] = std::from_chars(begin, end, seed);
  if (error != std::errc() || stop != end) return std::nullopt;
  return seed;
}

Outcome<nlohmann::json> read_json(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return failed(FailureKind::kUsage, "cannot read " + file.string());
  auto json = nlohmann::json::parse(in, nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) return failed(FailureKind::kUsage, file.string() + " is damaged");
  return json;
}

BatchJson json_of(const BatchIdentity& identity) {
  return {{"scenario", identity.scenario},
          {"description", identity.description},
          {"controller", identity.controller},
          {"version", identity.version},
          {"fingerprint", identity.fingerprint}};
}

/// "its controller is a, not b"; empty when they are the same.
std::string difference(const BatchIdentity& is, const BatchIdentity& wanted) {
  for (const auto& [what, a, b] :
       {std::tuple("scenario", is.scenario, wanted.scenario),
        std::tuple("controller", is.controller, wanted.controller),
        std::tuple("program's version", is.version, wanted.version),
        std::tuple("scenario's content", is.fingerprint, wanted.fingerprint),
        std::tuple("description", is.description, wanted.description)}) {
    if (a != b) return fmt::format("its {} is {}, not {}", what, a, b);
  }
  return {};
}

std::vector<std::uint64_t> seeds_in(const fs::path& directory, std::string_view ending) {
  std::vector<std::uint64_t> out;
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(directory, status)) {
    if (const auto seed = seed_of(entry.path().filename().string(), ending)) out.push_back(*seed);
  }
  std::ranges::sort(out);
  return out;
}

}  // namespace

std::string journal_name(std::uint64_t seed) {
  return fmt::format("journals/{}{}{}", kSeedPrefix, seed, kJournalEnding);
}

std::string BatchDirectory::journal(std::uint64_t seed) const {
  return (path_ / journal_name(seed)).string();
}

Outcome<void> BatchDirectory::write(const std::string& name, const std::string& text) const {
  const fs::path place = path_ / name;
  std::error_code status;
  fs::create_directories(place.parent_path(), status);
  files::DraftFile file(place.string());
  file.out() << text;
  if (auto done = file.commit(); !done) return failed(FailureKind::kUsage, done.error().message);
  return {};
}

Outcome<Batch> BatchDirectory::begin(const BatchIdentity& identity,
                                     const std::vector<std::uint64_t>& seeds) {
  Batch batch{.identity = identity};
  std::error_code status;
  if (fs::exists(path_ / "batch.json", status)) {
    auto there = read();
    if (!there) return there;
    if (const auto differs = difference(there->identity, identity); !differs.empty()) {
      return failed(FailureKind::kUsage,
                    fmt::format("{} holds another batch: {}", path_.string(), differs));
    }
    batch = std::move(*there);
  }
  std::vector<std::uint64_t> all;
  std::ranges::set_union(batch.seeds, seeds, std::back_inserter(all));
  batch.seeds = std::move(all);
  BatchJson json = json_of(identity);
  json["seeds"] = seeds_text(batch.seeds);
  if (auto done = write("batch.json", json.dump(1) + '\n'); !done) {
    return tl::unexpected(done.error());
  }
  fs::create_directories(path_ / "episodes", status);
  return batch;
}

Outcome<Batch> BatchDirectory::read() const {
  const auto json = read_json(path_ / "batch.json");
  if (!json) return tl::unexpected(json.error());
  Batch out;
  const auto text = [&](const char* key) {
    const auto found = json->find(key);
    return found != json->end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  out.identity = {text("scenario"), text("description"), text("controller"), text("version"),
                  text("fingerprint")};
  const std::string wanted = text("seeds");
  const auto seeds = wanted == "none" ? std::vector<std::uint64_t>() : parse_seeds(wanted);
  if (!seeds || out.identity.scenario.empty()) {
    return failed(FailureKind::kUsage, (path_ / "batch.json").string() + " is damaged");
  }
  out.seeds = *seeds;
  for (const std::uint64_t seed : seeds_in(path_ / "episodes", kEpisodeEnding)) {
    const fs::path file = path_ / "episodes" / fmt::format("seed_{}.json", seed);
    const auto episode = read_json(file);
    if (!episode) return tl::unexpected(episode.error());
    auto read = episode_of(*episode);
    if (!read || read->seed != seed) {
      return failed(FailureKind::kUsage, file.string() + " is damaged");
    }
    out.episodes.emplace(seed, std::move(*read));
  }
  out.journals = seeds_in(path_ / "journals", kJournalEnding);
  return out;
}

Outcome<void> BatchDirectory::keep(const Episode& episode) {
  return write(
      fmt::format("episodes/seed_{}.json", episode.seed),
      episode_json(episode).dump(1, ' ', false, BatchJson::error_handler_t::replace) + '\n');
}

Outcome<void> BatchDirectory::keep(const Attempts& attempts) {
  BatchJson causes = BatchJson::array();
  const std::size_t all = attempts.last_causes.size();
  for (std::size_t i = all - std::min(all, kMostCauses); i < all; ++i) {
    causes.push_back(
        {{"seed", attempts.last_causes[i].first}, {"cause", attempts.last_causes[i].second}});
  }
  const BatchJson json{{"repeated_attempts", attempts.repeated},
                       {"peak_world_mb", static_cast<double>(attempts.peak_world_bytes) / 1e6},
                       {"last_causes", causes}};
  return write("attempts.json",
               json.dump(1, ' ', false, BatchJson::error_handler_t::replace) + '\n');
}

Outcome<Batch> merge(const std::vector<Batch>& batches, const std::vector<std::string>& names) {
  Batch out{.identity = batches.front().identity};
  for (std::size_t i = 0; i < batches.size(); ++i) {
    const Batch& batch = batches[i];
    if (const auto differs = difference(batch.identity, out.identity); !differs.empty()) {
      return failed(FailureKind::kUsage, fmt::format("{} and {} are of different batches: {}",
                                                     names.front(), names[i], differs));
    }
    std::vector<std::uint64_t> seeds, journals;
    std::ranges::set_union(out.seeds, batch.seeds, std::back_inserter(seeds));
    std::ranges::set_union(out.journals, batch.journals, std::back_inserter(journals));
    out.seeds = std::move(seeds);
    out.journals = std::move(journals);
    for (const auto& [seed, episode] : batch.episodes) {
      const auto& [known, added] = out.episodes.emplace(seed, episode);
      if (!added && !(known->second == episode)) {
        return failed(FailureKind::kCheck,
                      fmt::format("{}: seed {} has different results ({}, state {}; {}, state "
                                  "{})",
                                  names[i], seed, episode.end_reason, episode.state_hash,
                                  known->second.end_reason, known->second.state_hash));
      }
    }
  }
  return out;
}

}  // namespace aprsim::client
