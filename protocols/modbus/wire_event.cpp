#include "protocols/modbus/wire_event.hpp"

#include <cstddef>
#include <string>

#include "modbus/request.hpp"

namespace aprsim::modbus_server {

protocols::WireEvent wire_event(std::span<const std::uint8_t> adu) {
  constexpr std::size_t kFunction = 7;  // behind the MBAP header
  return {.poll = adu.size() <= kFunction || !modbus::is_writing_function(adu[kFunction] & 0x7F),
          .id = adu.size() < 2 ? 0 : adu[0] * 256 + adu[1],
          .data = std::string(adu.begin(), adu.end())};
}

}  // namespace aprsim::modbus_server
