#include "protocols/web/register_view.hpp"

#include <algorithm>
#include <string>

namespace aprsim::web {
namespace {

const char* name_of(modbus::Area area) {
  switch (area) {
    case modbus::Area::kHoldingRegister:
      return "holding";
    case modbus::Area::kInputRegister:
      return "input";
    case modbus::Area::kCoil:
      return "coil";
    case modbus::Area::kDiscreteInput:
      break;
  }
  return "discrete";
}

std::uint32_t value_of(const modbus::RegisterInfo& info, std::uint16_t address,
                       const modbus::RegisterImage& image) {
  const auto at = static_cast<std::size_t>(address - modbus::kFirstAddress);
  switch (info.area) {
    case modbus::Area::kCoil:
      return image.coils[at];
    case modbus::Area::kDiscreteInput:
      return image.discrete[at];
    case modbus::Area::kHoldingRegister:
    case modbus::Area::kInputRegister:
      break;
  }
  const auto& words = info.area == modbus::Area::kHoldingRegister ? image.holding : image.input;
  const std::uint32_t high = words[at];
  return info.words() == 1 ? high : (high << 16) | words[at + 1];
}

/// Calls `visit` with each register, its address and its place in a row, -1 when it stands alone.
template <typename Visit>
void for_each_register(int beams, const Visit& visit) {
  for (const modbus::RegisterInfo& info : modbus::register_map()) {
    const int count = info.count == 1 ? 1 : std::min<int>(info.count, beams);
    for (int i = 0; i < count; ++i) {
      visit(info, static_cast<std::uint16_t>(info.address + i * info.words()),
            info.count == 1 ? -1 : i);
    }
  }
}

}  // namespace

void write_message(const modbus::ConveyorScaling& scaling, int beams, v1::RegisterMap& message) {
  for_each_register(beams, [&](const modbus::RegisterInfo& info, std::uint16_t address, int place) {
    auto& out = *message.add_registers();
    out.set_area(name_of(info.area));
    out.set_address(address);
    out.set_words(info.words());
    out.set_is_signed(info.encoding == modbus::Encoding::kInt16 ||
                      info.encoding == modbus::Encoding::kInt32);
    out.set_writable(info.access == modbus::Access::kReadWrite);
    out.set_name(std::string(info.name) + (place < 0 ? "" : "_" + std::to_string(place + 1)));
    out.set_unit(std::string(info.unit));
    out.set_resolution(modbus::resolution(info.scaling, scaling));
    out.set_meaning(std::string(info.meaning));
  });
}

void write_message(const modbus::RegisterImage& image, int beams, v1::RegisterValues& message) {
  for_each_register(beams, [&](const modbus::RegisterInfo& info, std::uint16_t address, int) {
    message.add_values(value_of(info, address, image));
  });
}

}  // namespace aprsim::web
