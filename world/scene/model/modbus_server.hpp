#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "world/api/description/register_map.hpp"

namespace aprsim::scene {

/// A register with its place in the scene's file.
struct PlacedRegister {
  api::Register data;
  std::string place;  ///< LINE:COLUMN: KEY of `signal`
};

/// A Modbus server of the scene.
struct ModbusServer {
  std::string name;
  std::vector<PlacedRegister> registers;
};

inline constexpr std::size_t kMaxModbusServers = 16;
inline constexpr std::size_t kMaxRegisters = 4096;  ///< of a server

}  // namespace aprsim::scene
