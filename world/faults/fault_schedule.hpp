#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "world/api/faults/fault.hpp"
#include "world/base/result.hpp"
#include "world/faults/fault_check.hpp"

namespace aprsim::world {

/// State of a gripper.
struct GripFacts {
  int held_body = -1;  ///< -1 = none
  bool open = true;    ///< commanded
};

/// Queries of triggers and faults to the cell, at the end of a step.
class CellFacts {
 public:
  virtual ~CellFacts() = default;
  [[nodiscard]] virtual int robots() const = 0;
  [[nodiscard]] virtual GripFacts grip(int robot) const = 0;
  [[nodiscard]] virtual const std::string& type_of(int body) const = 0;
  [[nodiscard]] virtual bool beam_broken(int eye) const = 0;
  /// SI; `joint` from 0.
  [[nodiscard]] virtual double quantity(faults::Quantity quantity, int robot, int joint) const = 0;
  /// Distance from a tray's middle, along the belt, to the end towards which it moves; nullopt for
  /// one that is not on the belt or a belt at rest [m].
  [[nodiscard]] virtual std::optional<double> distance_to_belt_end(int body) const = 0;
};

/// A lasting fault with its state.
struct ActiveFault {
  FaultSpec spec;
  SimTime begin{};
  SimTime open_until{};  ///< of a gripper that drops: open by itself until then
  bool caught = false;   ///< a jamming tray has reached its place

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [spec, begin, open_until, caught] = self;
    io(spec, begin, open_until, caught);
  }
};

/// The faults of a cell: pending, active and past ones. A copyable value, part of the cell's state.
/// It decides when faults begin and end; the owner executes them. Thread: sim.
class FaultSchedule {
 public:
  /// The faults that have begun and ended in one call, by number, in order.
  struct Changes {
    std::vector<std::uint64_t> begun, ended;
    bool shifted = false;  ///< the effect of an active fault has changed
    [[nodiscard]] bool any() const { return shifted || !begun.empty() || !ended.empty(); }

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [begun, ended, shifted] = self;
      io(begun, ended, shifted);
    }
  };

  /// Adds a resolved fault. Errors: kFailedPrecondition when too many are pending or active.
  [[nodiscard]] Result<std::uint64_t> inject(api::Ticket ticket, const api::InjectFault& request,
                                             FaultSpec spec);
  /// Ends one at the next advance(). Errors: kNotFound.
  [[nodiscard]] Result<void> end(std::uint64_t id);
  /// Seen by the next advance().
  void report(const std::string& event);

  /// No fault is pending or active.
  [[nodiscard]] bool idle() const { return open_.empty(); }
  /// Once a step boundary. Momentary faults begin and end in one call.
  const Changes& advance(SimTime time, std::uint64_t step, const CellFacts& facts);

  /// The fault with this number, pending, active or just ended. Null when unknown.
  [[nodiscard]] const FaultSpec* spec(std::uint64_t id) const;
  /// The active faults.
  [[nodiscard]] std::vector<ActiveFault> active() const;
  /// Sets the remark on a fault that has ended.
  void set_note(std::uint64_t id, const std::string& text);

  /// Renumbers bodies: `new_of` has the new number of each old one.
  void renumber(std::span<const int> new_of);

  /// For snapshots; null = none so far.
  [[nodiscard]] const api::InjectedFaultsPtr& list() const { return list_; }
  /// Approximate size in memory.
  [[nodiscard]] std::size_t bytes() const;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [last_id, open, over, past, changes, list] = self;
    io(last_id, open, over, past, changes, list);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(open_.size() <= api::kMaxOpenFaults && past_.size() <= api::kMaxPastFaults,
               "more faults than a cell keeps");
  }

 private:
  /// Memory of a trigger.
  struct Watch {
    std::vector<int> held;  ///< by each robot, -1 = nothing
    int grasps = 0;
    bool primed = false, beyond = false, reported = false;
    std::optional<SimTime> held_since;

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [held, grasps, primed, beyond, reported, held_since] = self;
      io(held, grasps, primed, beyond, reported, held_since);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.require(held.empty() || held.size() == in.counts().robots.size(),
                 "grips of another number of robots");
      for (const int body : held) in.index_or_none(In::kPart, body);
    }
  };
  struct Open {
    api::InjectedFault shown;
    ActiveFault active;
    Watch watch;
    std::optional<SimTime> end;
    bool give_up = false;  ///< an end was requested

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [shown, active, watch, end, give_up] = self;
      io(shown, active, watch, end, give_up);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.require(shown.kind == active.spec.kind && shown.robot == active.spec.robot,
                 "a fault with two kinds or robots");
    }
  };

  [[nodiscard]] bool triggered(Open& fault, SimTime time, const CellFacts& facts) const;
  [[nodiscard]] bool lets_go(Open& fault, const api::WhenPlaced& placed,
                             const CellFacts& facts) const;
  static bool grasps(Open& fault, const api::WhenGrasped& grasped, const CellFacts& facts);
  static bool rises(Watch& watch, bool now);
  /// Whether its effect has changed.
  static bool watch_active(Open& fault, SimTime time, const CellFacts& facts);
  void finish(Open& fault, std::uint64_t step);
  [[nodiscard]] Open* find(std::uint64_t id);
  void renew_list();

  std::uint64_t last_id_ = 0;
  std::vector<Open> open_;
  std::vector<Open> over_;  ///< in the latest advance()
  std::vector<api::InjectedFault> past_;
  Changes changes_;
  api::InjectedFaultsPtr list_;
};

}  // namespace aprsim::world
