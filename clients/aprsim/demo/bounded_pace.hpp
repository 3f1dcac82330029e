#pragma once

#include <optional>

#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {

/// Limits the speed ratio of the simulation for a client that must react in time; restores it at
/// its end.
class BoundedPace {
 public:
  explicit BoundedPace(CellConnection& connection) : connection_(connection) {}
  BoundedPace(const BoundedPace&) = delete;
  BoundedPace& operator=(const BoundedPace&) = delete;
  ~BoundedPace() {
    if (bounded_) static_cast<void>(connection_.set_speed(before_));
  }

  /// Limits the ratio to `pace`; a lower one stays.
  [[nodiscard]] Outcome<void> bound(double pace) {
    const auto snapshot = connection_.snapshot();
    if (!snapshot) return tl::unexpected(snapshot.error());
    if (snapshot->has_speed_target() && snapshot->speed_target() <= pace) return {};
    before_ = snapshot->has_speed_target() ? std::optional(snapshot->speed_target()) : std::nullopt;
    if (auto done = connection_.set_speed(pace); !done) return tl::unexpected(done.error());
    bounded_ = true;
    return {};
  }

 private:
  CellConnection& connection_;
  std::optional<double> before_;  // absent = as fast as possible
  bool bounded_ = false;
};

}  // namespace aprsim::client
