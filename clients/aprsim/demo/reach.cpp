#include "clients/aprsim/demo/reach.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::client {
namespace {

// Height differences below this barely change a reach of about a metre.
constexpr double kSameHeight_m = 0.05;

}  // namespace

double Reach::distance(const SlotView& place) const {
  return (place.X_WS.translation() - p_WB_).head<2>().norm();
}

bool Reach::excludes(const SlotView& place) const {
  return std::ranges::any_of(refusals_, [&](const Refusal& refusal) {
    if (refusal.place.name() == place.name()) return true;
    const double higher = place.X_WS.translation().z() - refusal.place.X_WS.translation().z();
    return refusal.too_far && std::abs(higher) < kSameHeight_m &&
           distance(place) >= distance(refusal.place);
  });
}

}  // namespace aprsim::client
