#pragma once

#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "server/replay/read_registers.hpp"
#include "server/replay/wire_reply.hpp"

namespace aprsim::server::journal {

/// Recomputes the replies of a Modbus connection, as far as the cell alone determines them: what is
/// read from registers. Thread: one at a time.
class ModbusReplies {
 public:
  explicit ModbusReplies(RegisterDeviation registers) : registers_(std::move(registers)) {}

  /// A unit of the client.
  void received(const std::string& unit, world::RunTime at);
  /// A unit to the client; absent = it reads nothing, or its request is unknown.
  [[nodiscard]] std::optional<WireReply> sent(const std::string& unit, world::RunTime at);

 private:
  struct Asked {
    world::RunTime at;
    std::string unit;
  };

  const RegisterDeviation registers_;
  std::deque<Asked> asked_;  ///< requests without a reply yet
};

}  // namespace aprsim::server::journal
