#include "protocols/modbus/banks/bound_map.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::modbus_server {
namespace {

modbus::Area area_of(api::RegisterArea area) {
  switch (area) {
    case api::RegisterArea::kCoil:
      return modbus::Area::kCoil;
    case api::RegisterArea::kDiscreteInput:
      return modbus::Area::kDiscreteInput;
    case api::RegisterArea::kInputRegister:
      return modbus::Area::kInputRegister;
    case api::RegisterArea::kHoldingRegister:
      break;
  }
  return modbus::Area::kHoldingRegister;
}

modbus::NumberEncoding encoding_of(api::RegisterEncoding encoding) {
  switch (encoding) {
    case api::RegisterEncoding::kBit:
      return modbus::NumberEncoding::kBit;
    case api::RegisterEncoding::kUint16:
      break;
    case api::RegisterEncoding::kInt16:
      return modbus::NumberEncoding::kInt16;
    case api::RegisterEncoding::kUint32:
      return modbus::NumberEncoding::kUint32;
    case api::RegisterEncoding::kInt32:
      return modbus::NumberEncoding::kInt32;
    case api::RegisterEncoding::kFloat32:
      return modbus::NumberEncoding::kFloat32;
  }
  return modbus::NumberEncoding::kUint16;
}

bool is_before(const BoundRegister& a, const BoundRegister& b) {
  return std::pair(a.area, a.address) < std::pair(b.area, b.address);
}

}  // namespace

BoundMap::BoundMap(const api::RegisterMap& map, const api::CellDescription& cell) {
  const api::SignalSources sources = api::signal_sources(cell);
  for (const api::Register& mapped : map.registers) {
    auto signal = api::bind_signal(mapped.signal, sources);
    if (!signal) continue;
    BoundRegister bound;
    bound.area = area_of(mapped.area);
    bound.address = mapped.address;
    bound.writable = mapped.writable;
    bound.format = {.encoding = encoding_of(mapped.encoding),
                    .low_word_first = mapped.word_order == api::WordOrder::kLowFirst,
                    .scale = mapped.scale,
                    .offset = mapped.offset,
                    .wraps = signal->info->wraps};
    bound.signal_name = mapped.signal;
    bound.signal = *std::move(signal);
    registers_.push_back(std::move(bound));
  }
  if (registers_.empty()) return;
  std::ranges::sort(registers_, is_before);
  int low = 0xFFFF, high = 0;
  for (const BoundRegister& each : registers_) {
    low = std::min(low, int{each.address});
    high = std::max(high, each.address + each.format.words() - 1);
  }
  first_ = static_cast<std::uint16_t>(low);
  size_ = static_cast<std::size_t>(high - low + 1);
  marks_.assign(size_, 0);
  for (const BoundRegister& each : registers_) {
    for (int i = 0; i < each.format.words(); ++i) {
      std::uint8_t& mark = marks_[static_cast<std::size_t>(each.address + i - low)];
      mark |= mark_of(each.area, false);
      if (each.writable) mark |= mark_of(each.area, true);
    }
  }
}

std::uint8_t BoundMap::mark_of(modbus::Area area, bool write) {
  return static_cast<std::uint8_t>((write ? kWritable : kReadable) << static_cast<int>(area));
}

bool BoundMap::has(modbus::Area area, std::uint16_t address, std::uint16_t count,
                   bool write) const {
  if (address < first_ || std::size_t{address} - first_ + count > size_) return false;
  const std::uint8_t wanted = mark_of(area, write);
  const auto begin = marks_.begin() + (address - first_);
  return std::all_of(begin, begin + count,
                     [wanted](std::uint8_t mark) { return (mark & wanted) != 0; });
}

std::vector<const BoundRegister*> BoundMap::touched(modbus::Area area, std::uint16_t address,
                                                    std::size_t count) const {
  std::vector<const BoundRegister*> found;
  BoundRegister from;
  from.area = area;
  // A value of two words may begin one address before.
  from.address = address == 0 ? address : static_cast<std::uint16_t>(address - 1);
  auto each = std::ranges::lower_bound(registers_, from, is_before);
  for (; each != registers_.end() && each->area == area; ++each) {
    if (each->address >= address + count) break;
    if (each->address + each->format.words() > address) found.push_back(&*each);
  }
  return found;
}

}  // namespace aprsim::modbus_server
