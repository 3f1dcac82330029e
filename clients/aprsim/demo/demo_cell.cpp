#include "clients/aprsim/demo/demo_cell.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/interruption.hpp"

namespace aprsim::client {

using std::chrono::steady_clock;

Outcome<CellView> DemoCell::view() const {
  const auto snapshot = connection.snapshot();
  if (!snapshot) return tl::unexpected(snapshot.error());
  return CellView(description, *snapshot);
}

Outcome<bool> DemoCell::wait_until(const std::function<bool(const v1::Snapshot&)>& met,
                                   std::chrono::milliseconds limit) const {
  constexpr auto kInterval = std::chrono::milliseconds(10);
  const auto deadline = steady_clock::now() + limit;
  while (true) {
    const auto snapshot = connection.snapshot();
    if (!snapshot) return tl::unexpected(snapshot.error());
    if (met(*snapshot)) return true;
    if (interruption::requested()) return failed(FailureKind::kInterrupted, "interrupted");
    if (steady_clock::now() > deadline) return false;
    interruption::sleep_until(steady_clock::now() + kInterval);
  }
}

void DemoCell::report(const std::string& source, const char* action, const std::string& text,
                      const nlohmann::ordered_json& fields) const {
  nlohmann::ordered_json object{{"source", source}, {"action", action}};
  if (!fields.is_null()) object.update(fields);
  console.show(fmt::format("{}: {}\n", source, text), object);
}

}  // namespace aprsim::client
