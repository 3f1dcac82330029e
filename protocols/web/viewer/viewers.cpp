#include "protocols/web/viewer/viewers.hpp"

#include <algorithm>

namespace aprsim::web {

void Viewers::limit_waiting() {
  // Messages that viewers share count once for each, so the sum is an upper bound.
  std::size_t bytes = 0;
  for (const auto& [id, viewer] : all_) bytes += viewer->waiting_bytes();
  if (bytes <= max_waiting_bytes_) return;
  auto viewers = all();
  std::ranges::sort(viewers, [](const auto& a, const auto& b) {
    return a->waiting_bytes() > b->waiting_bytes();
  });
  for (const auto& viewer : viewers) {
    if (bytes <= max_waiting_bytes_) return;
    bytes -= viewer->waiting_bytes();
    viewer->close("too slow", true);
  }
}

}  // namespace aprsim::web
