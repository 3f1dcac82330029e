#pragma once

#include <string>
#include <vector>

#include "aprsim/v1/cell.pb.h"

/// Modbus servers of a scene, for terminals and documents.
namespace aprsim::client {

/// A register with what its signal is.
struct RegisterRow {
  std::string area, encoding, word_order;  ///< as in scene files
  std::string unit, meaning;               ///< of the signal
  const v1::Register* data = nullptr;      ///< in the description
};

/// Rows of a server, by area and address. They refer to the description.
[[nodiscard]] std::vector<RegisterRow> register_rows(const v1::ModbusServer& map,
                                                     const v1::CellDescription& cell);

/// The server's registers as a table of text.
[[nodiscard]] std::string register_map_text(const v1::ModbusServer& map,
                                            const v1::CellDescription& cell);

}  // namespace aprsim::client
