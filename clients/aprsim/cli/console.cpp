#include "clients/aprsim/cli/console.hpp"

#include <ostream>

#include <nlohmann/json.hpp>

namespace aprsim::client {

void Console::show(const std::string& text, const nlohmann::ordered_json& object) {
  if (json) {
    // Texts of a peer may be no UTF-8; the line is valid JSON all the same.
    out << object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
  } else {
    out << text;
  }
  out.flush();
}

}  // namespace aprsim::client
