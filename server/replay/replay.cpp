#include "server/replay/replay.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "server/journal/command_message.hpp"
#include "world/cell/commands/command_check.hpp"
#include "world/cell/scene_editor.hpp"
#include "world/cell/state_bytes.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server::journal {
namespace {

tl::unexpected<Error> damaged(std::string message) {
  return fail(ErrorCode::kInvalidArgument, "journal", std::move(message));
}

/// Index and size of the largest difference of two lists of numbers.
struct Worst {
  std::size_t place = 0;
  double by = 0;
};
template <typename Recorded>
Worst worst_of(const Recorded& recorded, const std::vector<double>& here) {
  Worst worst;
  const auto count = std::min(static_cast<std::size_t>(recorded.size()), here.size());
  for (std::size_t i = 0; i < count; ++i) {
    const double by = std::abs(recorded[static_cast<int>(i)] - here[i]);
    if (!(by <= worst.by)) worst = {i, by};
  }
  return worst;
}

std::string joint_name(const api::CellDescription& cell, std::size_t place) {
  for (const auto& robot : cell.robots) {
    if (place < robot.joints.size()) return fmt::format("joint {} of {}", place + 1, robot.name);
    place -= robot.joints.size();
  }
  return "a joint";
}

std::string explain(const v1::JournalState& recorded, const world::StateSample& here,
                    const api::CellDescription& cell) {
  std::vector<std::string> parts;
  if (const Worst worst = worst_of(recorded.joints_rad(), here.joints_rad); worst.by != 0) {
    parts.push_back(fmt::format("{} by {:.3g} rad", joint_name(cell, worst.place), worst.by));
  }
  if (const Worst worst = worst_of(recorded.bodies_m(), here.bodies_m); worst.by != 0) {
    const std::size_t body = worst.place / 3;
    parts.push_back(fmt::format("{} by {:.3g} m along {}",
                                body < cell.bodies.size() ? cell.bodies[body].name : "a body",
                                worst.by, "xyz"[worst.place % 3]));
  }
  if (const double by = std::abs(recorded.belt_travel_m() - here.belt_travel_m); by != 0) {
    parts.push_back(fmt::format("the belt by {:.3g} m", by));
  }
  if (parts.empty())
    return "joints, bodies and belt are at the same places, but velocities or orientations differ";
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return "most of all " + text;
}

/// The bytes of a state that determine the run; those of event detection do not.
std::string bytes_of(world::WorldState state) {
  state.apart.clear();
  return world::to_bytes(state);
}

}  // namespace

Replay::Replay(const v1::JournalHeader& header, std::shared_ptr<const scene::Scene> scene,
               std::string directory)
    : scenes_(std::move(scene), std::move(directory)),
      state_version_(header.state_version()),
      world_(std::make_unique<world::World>(scenes_.of_header(),
                                            scenes_.models_of(scenes_.of_header()), header.seed(),
                                            std::span<robot::PlanPrefetcher* const>())) {}

Result<bool> Replay::process(const v1::JournalRecord& record) {
  if (result_.difference || over_) return false;
  Result<void> done;
  switch (record.record_case()) {
    case v1::JournalRecord::kEpoch:
      done = begin(record.epoch());
      break;
    case v1::JournalRecord::kCommand:
      done = command(record.command());
      break;
    case v1::JournalRecord::kState:
      done = compare(record.state());
      break;
    case v1::JournalRecord::kCheckpoint:
      done = checkpoint(record.checkpoint());
      break;
    case v1::JournalRecord::kGap:
      result_.missing += record.gap().records();
      if (record.gap().commands() > 0) {
        lost_ = true;
        ++result_.gaps;
      }
      break;
    case v1::JournalRecord::kEvent:
      if (record.event().kind() == v1::CELL_EVENT_KIND_WORLD_STOPPED) stopped_ = true;
      extend_to({record.event().epoch(), record.event().step()});
      break;
    case v1::JournalRecord::kWire:
      extend_to({record.wire().time().epoch(), record.wire().time().step()});
      break;
    default:
      break;
  }
  if (!done) return tl::unexpected(done.error());
  return !result_.difference && !over_;
}

void Replay::extend_to(world::RunTime time) {
  const bool later = time.epoch == last_reported_.epoch ? time.step > last_reported_.step
                                                        : time.epoch > last_reported_.epoch;
  if (later) last_reported_ = time;
}

Result<void> Replay::finish() {
  const bool further = last_reported_.epoch == epoch_ && last_reported_.step > world_->step_count();
  if (!further || lost_ || stopped_ || over_ || result_.difference) return {};
  v1::JournalTime time;
  time.set_epoch(last_reported_.epoch);
  time.set_step(last_reported_.step);
  return advance(time);
}

Result<void> Replay::advance(const v1::JournalTime& time) {
  if (time.epoch() != epoch_ || time.step() < world_->step_count()) {
    return damaged(fmt::format("step {} of epoch {} comes after step {} of epoch {}", time.step(),
                               time.epoch(), world_->step_count(), epoch_));
  }
  // Records after the end are ignored, whether or not one is at the end.
  std::uint64_t goal = time.step();
  const bool ends = end_ && (epoch_ > end_->epoch || (epoch_ == end_->epoch && goal > end_->step));
  if (ends) goal = epoch_ == end_->epoch ? end_->step : 0;
  try {
    while (world_->step_count() < goal && !over_) {
      world_->step();
      ++result_.steps;
      notify_watch();
    }
    over_ = over_ || ends;
  } catch (const std::exception& failure) {
    differs(
        fmt::format("the simulation stops here, but did not when recorded: {}", failure.what()));
  }
  return {};
}

Result<void> Replay::begin(const v1::JournalEpoch& epoch) {
  epoch_ = epoch.time().epoch();
  stopped_ = false;
  over_ = end_ && epoch_ > end_->epoch;
  lost_ = epoch.has_loaded_state();
  if (lost_ || over_) return {};
  const auto scene = scenes_.scene_of(epoch);
  if (!scene) return tl::unexpected(scene.error());
  try {
    build(*scene, epoch.seed());
  } catch (const std::exception& failure) {
    return damaged("the scene of an epoch cannot be built: " + std::string(failure.what()));
  }
  notify_watch();
  return {};
}

/// The revision shows watchers whether the description of the cell has changed.
void Replay::build(const std::shared_ptr<const scene::Scene>& scene, std::uint64_t seed) {
  const std::uint64_t revision = world_->description()->revision;
  const bool other = world_->scene() != scene;
  world_ = std::make_unique<world::World>(scene, scenes_.models_of(scene), seed,
                                          std::span<robot::PlanPrefetcher* const>());
  world_->set_revision(revision + (other ? 1 : 0));
}

Result<void> Replay::command(const v1::JournalCommand& message) {
  if (lost_ || stopped_) return {};
  auto command = to_command(message);
  if (!command) return tl::unexpected(command.error());
  if (std::holds_alternative<api::SimulationCommand>(command->body)) {
    return advance(message.time());
  }
  if (auto ok = world::check(*command, world_->description()); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto there = advance(message.time()); !there || result_.difference || over_) return there;
  ++result_.commands;
  std::string failure;
  if (auto done = world::apply_command(world_, message.ticket(), *command); !done) {
    failure = done.error().message;
  }
  if (failure.empty() != message.failure().empty()) {
    differs(fmt::format(
        "command {} {} in the replay and {} when recorded", message.sequence(),
        failure.empty() ? "succeeds" : "fails (" + failure + ")",
        message.failure().empty() ? "succeeded" : "failed (" + message.failure() + ")"));
  }
  notify_watch();
  return {};
}

Result<void> Replay::compare(const v1::JournalState& state) {
  if (lost_ || stopped_) return {};
  if (auto there = advance(state.time()); !there || result_.difference || over_) return there;
  ++result_.compared;
  if (state.hash() == world_->state_hash()) return {};
  differs(explain(state, world::sample_of(*world_), *world_->description()));
  return {};
}

Result<void> Replay::compare(const v1::JournalCheckpoint& checkpoint) {
  if (checkpoint.hash() != world_->state_hash()) {
    differs("the states of the checkpoint differ");
    return {};
  }
  if (state_version_ != world::kStateVersion) return {};
  auto recorded = scenes_.state_of(checkpoint);
  if (!recorded) return tl::unexpected(recorded.error());
  const std::string then = bytes_of(*std::move(recorded)), here = bytes_of(world_->save());
  if (then == here) return {};
  const auto first = std::ranges::mismatch(then, here).in1 - then.begin();
  differs(fmt::format(
      "the checkpoint's state (recorded {} bytes, replayed {}) differs at byte {}: joints, "
      "bodies and belt are equal so far, but may deviate later",
      then.size(), here.size(), first));
  return {};
}

Result<void> Replay::checkpoint(const v1::JournalCheckpoint& checkpoint) {
  if (!lost_) {
    if (stopped_) return {};
    if (auto there = advance(checkpoint.time()); !there || result_.difference || over_) {
      return there;
    }
    ++result_.compared;
    return compare(checkpoint);
  }
  if (state_version_ != world::kStateVersion) {
    return damaged(
        fmt::format("its checkpoints have layout {}, this program has {}: it can be replayed "
                    "from its start only",
                    state_version_, world::kStateVersion));
  }
  auto state = scenes_.state_of(checkpoint);
  if (!state) return tl::unexpected(state.error());
  if (state->scene != world_->scene()) build(state->scene, state->seed);
  world_->restore(*state);
  epoch_ = checkpoint.time().epoch();
  lost_ = false;
  if (world_->step_count() != checkpoint.time().step() ||
      world_->state_hash() != checkpoint.hash()) {
    differs("the checkpoint's state is not the one that was recorded");
  }
  notify_watch();
  return {};
}

void Replay::notify_watch() {
  if (watch_ && !watch_(*world_, {epoch_, world_->step_count()})) over_ = true;
}

void Replay::differs(const std::string& what) {
  result_.difference = {{epoch_, world_->step_count()}, what};
}

Result<scene::Scene> scene_of(const v1::JournalHeader& header, const std::string& directory) {
  namespace fs = std::filesystem;
  // Nothing outside of the directory.
  if (!scene::is_plain_name(header.scene())) {
    return damaged("the scene's name '" + header.scene().substr(0, 64) + "' is not a plain name");
  }
  scene::KnownFiles known;
  for (const v1::JournalFile& model : header.models()) {
    if (!scene::is_plain_name(model.name())) {
      return damaged("the model's name '" + model.name().substr(0, 64) + "' is not a plain name");
    }
    const fs::path path = fs::path(directory) / model.name();
    std::ofstream file(path, std::ios::binary);
    file << model.content();
    if (!file.flush()) {
      return fail(ErrorCode::kUnavailable, "journal", path.string() + " cannot be written");
    }
    known.models.push_back(path.string());
  }
  const std::string file = (fs::path(directory) / (header.scene() + ".yaml")).string();
  return scene::read_sent(header.scene_text(), file, scene::default_data_paths(), std::move(known));
}

std::vector<std::string> cautions(const v1::JournalHeader& header, const v1::JournalHeader& here) {
  std::vector<std::string> all;
  const auto differ = [&all](const char* what, const std::string& then, const std::string& now) {
    if (then == now) return;
    all.push_back(fmt::format("{} was {} and is {} here: bits may differ", what, then, now));
  };
  differ("the program's version", header.version(), here.version());
  // Journals of older programs lack it.
  const bool known = !header.world_sha256().empty();
  if (known && header.world_sha256() != here.world_sha256()) {
    all.push_back(fmt::format(
        "it was recorded by other sources: their digest was {:.12} and is {:.12} here: robots, "
        "contacts and sensors may behave differently",
        header.world_sha256(), here.world_sha256()));
  }
  if (known) differ("its build", header.build(), here.build());
  differ("its compiler", header.compiler(), here.compiler());
  differ("the processor", header.processor(), here.processor());
  return all;
}

}  // namespace aprsim::server::journal
