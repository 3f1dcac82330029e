#pragma once

#include "world/physics/gripper/suction.hpp"
#include "world/scene/model/robot.hpp"

namespace aprsim::physics {

/// Load of a vacuum cup in one step.
struct Suction {
  int body = -1;       ///< that covers most of the lip, by body index; -1 = none, or fixed
  double force_n = 0;  ///< on it, against the approach; the palm bears the reaction

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [body, force_n] = self;
    io(body, force_n);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.index_or_none(In::kFreeBody, body);
  }
};

/// A vacuum cup: the vacuum in it and the suction that follows.
class SuctionCup {
 public:
  explicit SuctionCup(const scene::VacuumCup& cup) : cup_(cup) {}

  [[nodiscard]] const scene::VacuumCup& settings() const { return cup_; }
  /// The ejector is on, or there is vacuum left.
  [[nodiscard]] bool has_suction(bool ejector_on) const;
  /// Once a step: how the lip lies, and on which body with which share of it (-1 = on none that
  /// moves).
  void advance(bool ejector_on, const LipSeal& seal, int body, double share, double step_s);
  /// Lets the air in.
  void vent() { state_ = {}; }

  [[nodiscard]] const Suction& suction() const { return state_.suction; }
  [[nodiscard]] double vacuum_pa() const { return state_.vacuum_pa; }
  /// The vacuum has come within 1 % of what it will be.
  [[nodiscard]] bool is_steady() const { return state_.steady; }
  /// At the highest vacuum, with the lip covered.
  [[nodiscard]] double full_force_n() const { return suction_force(cup_, cup_.max_vacuum_pa, 1); }

  struct State {
    Suction suction;
    double vacuum_pa = 0;
    bool steady = true;

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [suction, vacuum_pa, steady] = self;
      io(suction, vacuum_pa, steady);
    }
  };
  [[nodiscard]] const State& save() const { return state_; }
  void restore(const State& state) { state_ = state; }

 private:
  scene::VacuumCup cup_;
  State state_;
};

}  // namespace aprsim::physics
