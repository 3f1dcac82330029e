#pragma once

#include <cstdint>
#include <string>
#include <vector>

/// Modbus servers that a scene describes: registers that stand for signals of the cell.
namespace aprsim::api {

enum class RegisterArea : std::uint8_t { kCoil, kDiscreteInput, kInputRegister, kHoldingRegister };
/// 32-bit values take two registers.
enum class RegisterEncoding : std::uint8_t { kBit, kUint16, kInt16, kUint32, kInt32, kFloat32 };
enum class WordOrder : std::uint8_t { kHighFirst, kLowFirst };

/// A value in one of the areas, at one address or two: signal = count * scale + offset.
struct Register {
  std::string signal;  ///< name; see world/api/signals
  RegisterArea area = RegisterArea::kHoldingRegister;
  std::uint16_t address = 0;  ///< the first, as on the wire
  RegisterEncoding encoding = RegisterEncoding::kUint16;
  WordOrder word_order = WordOrder::kHighFirst;
  double scale = 1, offset = 0;
  bool writable = false;

  /// Addresses that it takes.
  [[nodiscard]] int words() const { return encoding >= RegisterEncoding::kUint32 ? 2 : 1; }
};

/// A server, by name. Addresses without a register do not exist.
struct RegisterMap {
  std::string name;
  std::vector<Register> registers;  ///< in the order of the scene
};

}  // namespace aprsim::api
