#include <array>
#include <cstdio>
#include <string>

#include "modbus/register_map.hpp"

namespace aprsim::modbus {
namespace {

constexpr std::array kAreas{Area::kHoldingRegister, Area::kInputRegister, Area::kCoil,
                            Area::kDiscreteInput};

std::string_view title(Area area) {
  switch (area) {
    case Area::kHoldingRegister:
      return "Holding registers (FC 3 reads, FC 6, 16 and 22 write, FC 23 does both)";
    case Area::kInputRegister:
      return "Input registers (FC 4 reads)";
    case Area::kCoil:
      return "Coils (FC 1 reads, FC 5 and 15 write)";
    case Area::kDiscreteInput:
      return "Discrete inputs (FC 2 reads)";
  }
  return {};
}

std::string_view name_of(Encoding encoding) {
  switch (encoding) {
    case Encoding::kBit:
      return "bit";
    case Encoding::kUint16:
      return "uint16";
    case Encoding::kInt16:
      return "int16";
    case Encoding::kUint32:
      return "uint32";
    case Encoding::kInt32:
      return "int32";
  }
  return {};
}

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

std::string hex(unsigned address) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "0x%04X", address);
  return text.data();
}

void append_column(std::string& line, std::string_view text, std::size_t width) {
  line += text;
  if (text.size() < width) line.append(width - text.size(), ' ');
  line += ' ';
}

std::string range(const RegisterInfo& info) {
  const std::int64_t span = info.words() == 2 ? 0xFFFFFFFFLL : 0xFFFF;
  if (info.max - info.min == span) return "all";
  return std::to_string(info.min) + ".." + std::to_string(info.max);
}

std::string row(const RegisterInfo& info, const ConveyorScaling& scaling) {
  std::string address = hex(info.address);
  if (info.span() > 1) address += "-" + hex(info.address + info.span() - 1U);
  std::string count;
  if (const double unit = resolution(info.scaling, scaling); unit > 0) {
    count = number(unit) + " " + std::string(info.unit);
  }
  std::string line = "  ";
  append_column(line, address, 13);
  append_column(line, info.access == Access::kReadWrite ? "RW" : "R", 2);
  append_column(line, name_of(info.encoding), 6);
  append_column(line, info.name, 12);
  append_column(line, range(info), 8);
  append_column(line, count, 9);
  line += info.meaning;
  if (info.area == Area::kHoldingRegister && info.address == kDirectionRegister) {
    line += scaling.one_is_forward ? "; here 1 = forward, 0 = reverse"
                                   : "; here 0 = forward, 1 = reverse";
  }
  return line + "\n";
}

}  // namespace

double resolution(Scaling scaling, const ConveyorScaling& conveyor) {
  switch (scaling) {
    case Scaling::kNone:
      return 0;
    case Scaling::kSpeed:
      return conveyor.m_s_per_count();
    case Scaling::kPosition:
      return kMetresPerPositionCount;
    case Scaling::kMilliseconds:
    case Scaling::kMillimetres:
    case Scaling::kMilliamperes:
      return 1e-3;
    case Scaling::kDecagrams:
      return 1e-2;
  }
  return 0;
}

std::string register_map_text(const ConveyorScaling& scaling) {
  const std::string first = hex(kFirstAddress), last = hex(kFirstAddress + kAddressCount - 1U);
  std::string text = "Conveyor Modbus/TCP map. Addresses are those on the wire, " + first + " to " +
                     last + " in every area. Any unit id.\nSpeed full scale: 32768 counts = " +
                     number(scaling.full_scale_m_s) +
                     " m/s. 32-bit values: high word at the lower address; read both words in one "
                     "request.\n";
  for (const Area area : kAreas) {
    text += "\n" + std::string(title(area)) + "\n";
    bool any = false;
    for (const RegisterInfo& info : register_map()) {
      if (info.area != area) continue;
      if (!any) text += "  address       ac type   name         counts   one count meaning\n";
      any = true;
      text += row(info, scaling);
    }
    const bool writable = area == Area::kHoldingRegister || area == Area::kCoil;
    text += any ? "  The rest is" : "  All of it is";
    text += writable ? " unused PLC memory: 0 at reset, keeps what is written.\n"
                     : " unused PLC memory: reads 0.\n";
  }
  return text;
}

}  // namespace aprsim::modbus
