#pragma once

#include <vector>

#include "clients/aprsim/conform/check.hpp"

/// The groups that the checks of a CRCL server come in. Each add() appends its own to the list.
namespace aprsim::client::conform {

/// F: how documents follow each other on the wire, and what XML may look like.
namespace documents {
void add(std::vector<Check>& checks);
}
/// V: commands that are XML, but not what the schema asks for.
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
/// N: several connections, and clients that do their worst.
namespace connections {
void add(std::vector<Check>& checks);
}
/// M: motion, small and slow.
namespace motion {
void add(std::vector<Check>& checks);
}

}  // namespace aprsim::client::conform
