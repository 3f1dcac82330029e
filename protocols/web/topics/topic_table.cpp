#include "protocols/web/topics/topic_table.hpp"

#include <memory>
#include <utility>

#include "protocols/messages/history_message.hpp"
#include "protocols/messages/write_message.hpp"
#include "protocols/web/topics/register_view.hpp"
#include "protocols/web/topics/topic_message.hpp"

namespace aprsim::web {
namespace {

using namespace std::chrono_literals;
using Delivery = Topic::Delivery;

constexpr std::size_t kEventBytesPerTick = std::size_t{96} << 10;

/// Assigns increasing numbers to successive objects.
template <typename T>
class Counted {
 public:
  Topic::Revision operator()(std::shared_ptr<const T> now) {
    if (now != latest_) ++revision_;
    latest_ = std::move(now);
    return revision_;
  }

 private:
  std::shared_ptr<const T> latest_;
  Topic::Revision revision_ = 0;
};

bool snapshot_due(const Audience& viewer) { return viewer.snapshot_due; }

/// Sent before the cell, where they differ from the viewer's.
Topic appearance(const TopicSources& sources) {
  struct State {
    SceneAppearance appearance;
    Counted<api::CellDescription> cells;
    Topic::Revision cell = 0, revision = 0;
  };
  const auto state = std::make_shared<State>();
  const auto revision = [state, &sources] {
    const auto& cell = sources.now->cell;
    const Topic::Revision now = state->cells(cell);
    if (std::exchange(state->cell, now) != now && state->appearance.follow(*cell, sources.visual)) {
      ++state->revision;
    }
    return state->revision;
  };
  return {.name = "appearance",
          .delivery = Delivery::kMust,
          .wanted = snapshot_due,
          .revision = revision,
          .write = [state](auto& update) {
            *update.mutable_appearance() = state->appearance.message();
          }};
}

Topic cell(const TopicSources& sources) {
  return {.name = "cell",
          .delivery = Delivery::kMust,
          .wanted = snapshot_due,
          .revision =
              [&sources, cells = Counted<api::CellDescription>()]() mutable {
                return cells(sources.now->cell);
              },
          .write =
              [&sources](auto& update) {
                protocols::write_message(*sources.now->cell, *update.mutable_cell());
              }};
}

Topic snapshot(const TopicSources& sources) {
  return {.name = "snapshot",
          .delivery = Delivery::kLatest,
          .wanted = snapshot_due,
          .write =
              [&sources](auto& update) {
                write_without_names(*sources.now, sources.instance_id, *update.mutable_snapshot());
              },
          .on_skipped = sources.on_skipped_snapshot};
}

Topic registers(const TopicSources& sources) {
  return {.name = "registers",
          .period = 100ms,
          .delivery = Delivery::kLatest,
          .wanted = [](const Audience& viewer) { return viewer.watch.registers(); },
          .write =
              [&sources](auto& update) {
                sources.device->refresh();
                write_message(sources.device->image(), sources.beams, *update.mutable_registers());
              }};
}

Topic status(const TopicSources& sources) {
  return {.name = "status",
          .period = 1s,
          .write_own = [&sources](const Audience& viewer, auto seen, auto& update) {
            auto& status = *update.mutable_status();
            status.set_skipped_snapshots(viewer.skipped_snapshots);
            for (const ListenerCount& listener : sources.listeners()) {
              auto& out = *status.add_listeners();
              out.set_name(listener.name);
              out.set_port(listener.port);
              out.set_clients(static_cast<std::uint32_t>(listener.clients));
            }
            if (const auto& saved = sources.now->saved_states) {
              for (const api::SavedState& state : saved->states) {
                status.add_saved_states(state.name);
              }
            }
            return seen.value_or(0) + 1;
          }};
}

Topic faults(const TopicSources& sources) {
  return {.name = "faults",
          .period = 500ms,
          .first_at_once = true,
          .revision = [&sources] { return sources.faults->revision(); },
          .write = [&sources](
                       auto& update) { write_message(*sources.faults, *update.mutable_faults()); }};
}

Topic programs(const TopicSources& sources) {
  struct State {
    std::shared_ptr<const ProgramStatus> status;
    Counted<ProgramStatus> statuses;
  };
  const auto state = std::make_shared<State>();
  return {.name = "programs",
          .period = 250ms,
          .revision =
              [state, &sources] {
                state->status = sources.programs ? sources.programs->status() : no_programs();
                return state->statuses(state->status);
              },
          .write =
              [state](auto& update) { write_message(*state->status, *update.mutable_programs()); }};
}

Topic history(const TopicSources& sources) {
  return {.name = "history", .period = 250ms, .write = [&sources](auto& update) {
            protocols::write_message(sources.history->spans(), *update.mutable_history());
          }};
}

Topic bookmarks(const TopicSources& sources) {
  return {.name = "bookmarks",
          .period = 1s,
          .revision = [&sources] { return sources.history->bookmark_revision(); },
          .write =
              [&sources](auto& update) {
                protocols::write_message(sources.history->bookmarks(), *update.mutable_bookmarks());
              }};
}

/// A viewer receives the next events once it has received the previous ones, so that at most one
/// message waits for it. The revision is the number of the next event.
Topic wire_events(protocols::WireTap& tap, const char* wire, bool (v1::Watch::*watched)() const) {
  return {
      .name = wire,
      .delivery = Delivery::kMust,
      .wanted =
          [watched](const Audience& viewer) { return (viewer.watch.*watched)() && viewer.idle; },
      .write_own =
          [&tap, wire, events = std::vector<protocols::WireEventPtr>()](
              const Audience& viewer, auto seen, auto& update) mutable {
            events.clear();
            const Topic::Revision next =
                tap.read(seen.value_or(1), viewer.watch.polls(), kEventBytesPerTick, events);
            if (events.empty()) return next;
            auto& out = *update.mutable_wire_events();
            out.set_wire(wire);
            out.set_dropped(tap.given_up());
            for (const auto& event : events) write_message(*event, *out.add_events());
            return next;
          }};
}

}  // namespace

std::shared_ptr<const ProgramStatus> no_programs() {
  static const auto none = std::make_shared<const ProgramStatus>(
      ProgramStatus{.refusal = "This daemon starts no programs (web.programs is false)."});
  return none;
}

std::vector<Topic> all_topics(const TopicSources& sources) {
  std::vector<Topic> all{appearance(sources), cell(sources), snapshot(sources), registers(sources)};
  if (sources.listeners) all.push_back(status(sources));
  all.push_back(faults(sources));
  all.push_back(programs(sources));
  if (sources.history) {
    all.push_back(history(sources));
    all.push_back(bookmarks(sources));
  }
  if (sources.crcl_tap) {
    all.push_back(wire_events(*sources.crcl_tap, "crcl", &v1::Watch::crcl));
  }
  if (sources.modbus_tap) {
    all.push_back(wire_events(*sources.modbus_tap, "modbus", &v1::Watch::modbus));
  }
  return all;
}

}  // namespace aprsim::web
