#include "clients/aprsim/conform/modbus_check_groups.hpp"

namespace aprsim::client::conform {

std::vector<Check> modbus_checks() {
  std::vector<Check> checks;
  frames::add(checks);
  functions::add(checks);
  registers::add(checks);
  return checks;
}

}  // namespace aprsim::client::conform
