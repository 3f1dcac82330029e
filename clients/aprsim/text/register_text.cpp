#include "clients/aprsim/text/register_text.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "world/api/signals/signal_table.hpp"

namespace aprsim::client {
namespace {

/// "UINT16" of "REGISTER_ENCODING_UINT16", in small letters.
std::string word_of(const std::string& enumerator, std::string_view prefix) {
  std::string word = enumerator.substr(std::min(prefix.size(), enumerator.size()));
  std::ranges::transform(word, word.begin(), [](unsigned char c) { return std::tolower(c); });
  return word;
}

std::string area_of(const v1::Register& mapped) {
  switch (mapped.area()) {
    case v1::REGISTER_AREA_INPUT_REGISTER:
      return "input";
    case v1::REGISTER_AREA_HOLDING_REGISTER:
      return "holding";
    default:
      return word_of(v1::RegisterArea_Name(mapped.area()), "REGISTER_AREA_");
  }
}

std::string title_of(v1::RegisterArea area) {
  switch (area) {
    case v1::REGISTER_AREA_COIL:
      return "Coils (FC 1 reads, FC 5 and 15 write)";
    case v1::REGISTER_AREA_DISCRETE_INPUT:
      return "Discrete inputs (FC 2 reads)";
    case v1::REGISTER_AREA_INPUT_REGISTER:
      return "Input registers (FC 4 reads)";
    default:
      return "Holding registers (FC 3 reads, FC 6, 16 and 22 write, FC 23 does both)";
  }
}

bool is_wide(const v1::Register& mapped) {
  return mapped.encoding() >= v1::REGISTER_ENCODING_UINT32;
}

/// The unit of a device's input; empty for every other signal.
std::string input_unit(const std::string& signal, const v1::CellDescription& cell) {
  for (const auto& device : cell.devices()) {
    for (const auto& input : device.inputs()) {
      if (device.name() + '.' + input.signal() == signal) return input.unit();
    }
  }
  return {};
}

std::string line_of(const RegisterRow& row) {
  const v1::Register& data = *row.data;
  std::string address = fmt::format("{}", data.address());
  if (is_wide(data)) address += fmt::format("-{}", data.address() + 1);
  std::string value = row.encoding == "bit" ? "" : fmt::format("{:g}", data.scale());
  if (data.offset() != 0) value += fmt::format("{:+g}", data.offset());
  if (!row.unit.empty()) value += ' ' + row.unit;
  const std::string type = is_wide(data) ? row.encoding + ", " + row.word_order : row.encoding;
  return fmt::format("  {:<11} {:<2} {:<19} {:<12} {}: {}\n", address, data.writable() ? "RW" : "R",
                     type, value, data.signal(), row.meaning);
}

}  // namespace

std::vector<RegisterRow> register_rows(const v1::ModbusServer& map,
                                       const v1::CellDescription& cell) {
  std::vector<RegisterRow> rows;
  for (const v1::Register& data : map.registers()) {
    RegisterRow row;
    row.area = area_of(data);
    row.encoding = word_of(v1::RegisterEncoding_Name(data.encoding()), "REGISTER_ENCODING_");
    row.word_order = word_of(v1::WordOrder_Name(data.word_order()), "WORD_ORDER_");
    const api::SignalInfo* info = api::find_signal_info(data.signal());
    row.unit = input_unit(data.signal(), cell);
    if (info != nullptr) {
      if (row.unit.empty()) row.unit = info->unit;
      row.meaning = info->meaning;
    }
    row.data = &data;
    rows.push_back(std::move(row));
  }
  std::ranges::stable_sort(rows, [](const RegisterRow& a, const RegisterRow& b) {
    return std::tuple(a.data->area(), a.data->address()) <
           std::tuple(b.data->area(), b.data->address());
  });
  return rows;
}

std::string register_map_text(const v1::ModbusServer& map, const v1::CellDescription& cell) {
  std::string text = fmt::format(
      "Modbus/TCP map of the server {}. Addresses are those on the wire; others do not "
      "exist. Any unit id.\nA signal is its count times the value of one count, plus "
      "the offset.\n",
      map.name());
  v1::RegisterArea area = v1::REGISTER_AREA_UNSPECIFIED;
  for (const RegisterRow& row : register_rows(map, cell)) {
    if (std::exchange(area, row.data->area()) != row.data->area()) {
      text +=
          "\n" + title_of(area) + "\n  address     ac type                one count    signal\n";
    }
    text += line_of(row);
  }
  return text;
}

}  // namespace aprsim::client
