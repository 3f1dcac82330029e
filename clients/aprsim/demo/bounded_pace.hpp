#pragma once

#include <optional>

#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {

/// Holds the simulation to a pace, for who watches it and has to answer in time; gives back the
/// pace that was set when it ends.
class BoundedPace {
 public:
  explicit BoundedPace(CellConnection& connection) : connection_(connection) {}
  BoundedPace(const BoundedPace&) = delete;
  BoundedPace& operator=(const BoundedPace&) = delete;
  ~BoundedPace() {
    if (bounded_) static_cast<void>(connection_.set_speed(before_));
  }

  /// At most `pace`; a slower one stays.
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
