#pragma once

#include <vector>

#include "clients/aprsim/conform/check.hpp"

/// Groups of checks of a CRCL server. Each function appends its checks to the list.
namespace aprsim::client::conform {

/// F: framing of documents and forms of XML.
namespace documents {
void add(std::vector<Check>& checks);
}
/// V: XML that violates the schema.
namespace validity {
void add(std::vector<Check>& checks);
}
/// S: statuses.
namespace statuses {
void add(std::vector<Check>& checks);
}
/// C: command ids, states, errors, sessions.
namespace commands {
void add(std::vector<Check>& checks);
}
/// G: guards of commands.
namespace guards {
void add(std::vector<Check>& checks);
}
/// U: units and other settings.
namespace settings {
void add(std::vector<Check>& checks);
}
/// N: several connections, and misbehaving clients.
namespace connections {
void add(std::vector<Check>& checks);
}
/// M: motion, small and slow.
namespace motion {
void add(std::vector<Check>& checks);
}

}  // namespace aprsim::client::conform
