#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "modbus/request_bytes.hpp"

/// The requirements of the specification for every function at every limit (MODBUS Application
/// Protocol Specification V1.1b3, sections 6 and 7), for a device whose addresses are 0x8000 to
/// 0x80FF.
namespace aprsim::modbus::conformance {

inline constexpr int kAccepted = 0;

struct ConformanceCase {
  std::string name;     ///< "Fc3OneTooMany"
  std::string section;  ///< of the specification
  Bytes pdu;
  int exception;  ///< expected code, or kAccepted
};

/// The section of the specification about a function.
[[nodiscard]] std::string section_of(std::uint8_t function);

[[nodiscard]] std::vector<ConformanceCase> conformance_cases();

}  // namespace aprsim::modbus::conformance
