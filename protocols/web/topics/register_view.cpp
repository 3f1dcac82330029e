#include "protocols/web/topics/register_view.hpp"

#include <algorithm>
#include <string>

#include <fmt/format.h>

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

/// Calls `visit` with each register, its address and its index in an array, -1 for a single one.
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
    out.set_min(info.min);
    out.set_max(info.max);
  });
}

void write_message(const modbus::RegisterImage& image, int beams, v1::RegisterValues& message) {
  for_each_register(beams, [&](const modbus::RegisterInfo& info, std::uint16_t address, int) {
    message.add_values(value_of(info, address, image));
  });
}

modbus::Request RegisterWrite::request() const {
  modbus::Request request;
  request.function = function;
  request.address = address;
  request.quantity = 1;
  request.data = data;
  return request;
}

Result<RegisterWrite> to_register_write(const v1::WriteRegister& message) {
  const bool coil = message.area() == name_of(modbus::Area::kCoil);
  if (!coil && message.area() != name_of(modbus::Area::kHoldingRegister)) {
    return fail(ErrorCode::kInvalidArgument, "area",
                fmt::format("'{}' is neither holding nor coil, the areas that can be written",
                            message.area()));
  }
  const modbus::RegisterInfo* info = nullptr;
  if (message.address() <= UINT16_MAX) {
    info = modbus::find_register(coil ? modbus::Area::kCoil : modbus::Area::kHoldingRegister,
                                 static_cast<std::uint16_t>(message.address()));
  }
  if (info == nullptr || info->access != modbus::Access::kReadWrite || info->words() != 1) {
    return fail(ErrorCode::kInvalidArgument, "address",
                fmt::format("0x{:04X} is no {} of the map that can be written", message.address(),
                            coil ? "coil" : "holding register"));
  }
  if (message.value() < info->min || message.value() > info->max) {
    return fail(ErrorCode::kInvalidArgument, "value",
                fmt::format("{} is not in {}..{}, the range of {} (0x{:04X})", message.value(),
                            info->min, info->max, info->name, info->address));
  }
  RegisterWrite write;
  write.address = info->address;
  if (coil) {
    write.function = modbus::Function::kWriteSingleCoil;
    write.data[0] = message.value() != 0 ? 0xFF : 0;
  } else {
    write.data = {static_cast<std::uint8_t>((message.value() >> 8) & 0xFF),
                  static_cast<std::uint8_t>(message.value() & 0xFF)};
  }
  return write;
}

}  // namespace aprsim::web
