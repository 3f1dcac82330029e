#include <cstdint>
#include <map>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "clients/aprsim/trace/action.hpp"
#include "modbus/register_map.hpp"
#include "modbus/request_validator.hpp"

namespace aprsim::trace {
namespace {

std::span<const std::uint8_t> bytes_of(const std::string& data) {
  return {reinterpret_cast<const std::uint8_t*>(data.data()), data.size()};
}

/// "speed", or "0x8002" where the map has no name for it.
std::string register_name(modbus::Area area, unsigned address) {
  const auto* info = modbus::find_register(area, static_cast<std::uint16_t>(address));
  if (info == nullptr || info->span() > 1) return fmt::format("0x{:04x}", address);
  return std::string(info->name);
}

modbus::Area area_of(const modbus::Request& request) {
  switch (request.function) {
    case modbus::Function::kReadCoils:
    case modbus::Function::kWriteSingleCoil:
    case modbus::Function::kWriteMultipleCoils:
      return modbus::Area::kCoil;
    case modbus::Function::kReadDiscreteInputs:
      return modbus::Area::kDiscreteInput;
    case modbus::Function::kReadInputRegisters:
      return modbus::Area::kInputRegister;
    default:
      return modbus::Area::kHoldingRegister;
  }
}

std::string read_text(modbus::Area area, unsigned address, unsigned quantity) {
  static constexpr const char* kAreas[] = {"coils", "discrete inputs", "input registers",
                                           "holding registers"};
  return fmt::format("{} 0x{:04x} to 0x{:04x}", kAreas[static_cast<std::size_t>(area)], address,
                     address + quantity - 1);
}

Action write_action(const modbus::Request& request) {
  const modbus::Area area = area_of(request);
  Action action;
  action.kind = "write " + register_name(area, request.address);
  if (request.quantity > 1) {
    action.kind += " to " + register_name(area, request.address + request.quantity - 1U);
  }
  const auto add = [&](const std::string& name, double value) {
    action.fields.push_back({name, Number{Quantity::kCount, value}});
  };
  if (request.function == modbus::Function::kMaskWriteRegister) {
    action.kind = "mask " + register_name(area, request.address);
    add("and-mask", request.word(0));
    add("or-mask", request.word(1));
    return action;
  }
  for (std::uint16_t i = 0; i < request.quantity; ++i) {
    const std::string name = register_name(area, request.address + unsigned{i});
    add(name, request.is_coil_write() ? (request.bit(i) ? 1 : 0) : request.word(i));
  }
  return action;
}

/// Goes through what one PLC was asked and answered.
class ModbusReader {
 public:
  void take(const WireRecord& record) {
    const auto adu = bytes_of(record.wire.data());
    if (record.wire.content() == v1::WIRE_CONTENT_RECEIVED) request(record, adu);
    if (record.wire.content() == v1::WIRE_CONTENT_SENT) reply(record, adu);
  }
  WireActions take_result() {
    for (Action& action : out_.actions) {
      if (action.outcome.empty()) action.outcome = "no answer";
    }
    return std::move(out_);
  }

 private:
  using Transaction = std::pair<std::uint64_t, unsigned>;  // connection and number
  static Transaction transaction_of(const WireRecord& record, std::span<const std::uint8_t> adu) {
    return {record.wire.connection(), adu[0] * 256U + adu[1]};
  }

  void request(const WireRecord& record, std::span<const std::uint8_t> adu) {
    const auto validated = modbus::validate_request(adu);
    if (validated.verdict == modbus::Verdict::kIdentification) {
      ++out_.polls;
      ++out_.reads["the device's identification"];
      return;
    }
    Action action;
    if (validated.verdict != modbus::Verdict::kRequest) {
      action.kind = "wrong request";
      std::string hex;
      // The transaction's number is nobody's business.
      for (const std::uint8_t byte : adu.subspan(std::min<std::size_t>(2, adu.size()))) {
        hex += fmt::format("{:02x} ", byte);
      }
      action.fields.push_back({"bytes", hex});
    } else if (!validated.request.is_write()) {
      const modbus::Request& read = validated.request;
      ++out_.polls;
      ++out_.reads[read_text(area_of(read), read.address, read.quantity)];
      return;
    } else {
      action = write_action(validated.request);
      if (validated.request.function == modbus::Function::kReadWriteRegisters) {
        ++out_.reads[read_text(modbus::Area::kHoldingRegister, validated.request.read_address,
                               validated.request.read_quantity)];
      }
    }
    action.time_s = record.time_s;
    if (adu.size() > modbus::kHeaderSize) {
      waiting_[transaction_of(record, adu)] = out_.actions.size();
    }
    out_.actions.push_back(std::move(action));
  }

  void reply(const WireRecord& record, std::span<const std::uint8_t> adu) {
    if (adu.size() <= modbus::kHeaderSize) return;
    const auto at = waiting_.find(transaction_of(record, adu));
    if (at == waiting_.end()) return;
    Action& action = out_.actions[at->second];
    waiting_.erase(at);
    const bool refused = (adu[modbus::kHeaderSize] & 0x80U) != 0;
    action.outcome = !refused ? "done"
                              : fmt::format("exception {}", adu.size() > modbus::kHeaderSize + 1
                                                                ? adu[modbus::kHeaderSize + 1]
                                                                : 0);
    action.duration_s = record.time_s - action.time_s;
  }

  std::map<Transaction, std::size_t> waiting_;  ///< the write of each: its place
  WireActions out_;
};

}  // namespace

WireActions modbus_actions(const Records& records) {
  ModbusReader reader;
  for (const WireRecord* record : records) reader.take(*record);
  return reader.take_result();
}

}  // namespace aprsim::trace
