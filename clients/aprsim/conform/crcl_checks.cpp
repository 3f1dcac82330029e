#include "clients/aprsim/conform/crcl_check_groups.hpp"

namespace aprsim::client::conform {

std::vector<Check> crcl_checks() {
  std::vector<Check> checks;
  documents::add(checks);
  validity::add(checks);
  statuses::add(checks);
  commands::add(checks);
  guards::add(checks);
  settings::add(checks);
  connections::add(checks);
  motion::add(checks);
  return checks;
}

}  // namespace aprsim::client::conform
