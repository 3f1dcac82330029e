#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "modbus/request.hpp"
#include "world/api/snapshot/snapshot.hpp"

/// Injected faults of the Modbus wire that change replies. Thread: any.
namespace aprsim::modbus_server {

/// The exception that every request gets; absent = requests are executed.
[[nodiscard]] std::optional<modbus::ExceptionCode> injected_exception(
    const api::Snapshot& snapshot);

/// The reply, preceded by a stray one if that fault is active.
[[nodiscard]] std::vector<std::uint8_t> with_strays(std::vector<std::uint8_t> reply,
                                                    const api::Snapshot& snapshot);

}  // namespace aprsim::modbus_server
