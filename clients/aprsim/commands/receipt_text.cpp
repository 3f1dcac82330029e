#include "clients/aprsim/commands/receipt_text.hpp"

#include <fmt/format.h>

#include "clients/aprsim/text/status_text.hpp"

namespace aprsim::client {

Outcome<void> show_receipt(const char* done, const std::string& what,
                           const Outcome<v1::Receipt>& receipt, Console& console,
                           const nlohmann::ordered_json& fields) {
  if (!receipt) return tl::unexpected(receipt.error());
  nlohmann::ordered_json object{{"done", done},
                                {"step", receipt->step()},
                                {"sim_time_s", seconds(receipt->sim_time())},
                                {"epoch", receipt->epoch()}};
  object.update(fields);
  console.show(fmt::format("{} at step {} ({:.3f} s), epoch {}\n", what, receipt->step(),
                           seconds(receipt->sim_time()), receipt->epoch()),
               object);
  return {};
}

}  // namespace aprsim::client
