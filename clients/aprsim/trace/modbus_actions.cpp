#include <algorithm>
#include <cstdint>
#include <deque>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clients/aprsim/trace/action.hpp"
#include "modbus/register_map.hpp"
#include "modbus/request_validator.hpp"

namespace aprsim::trace {
namespace {

/// Whether a listener is the conveyor's PLC; every other one serves a map of a scene.
bool is_conveyor(std::string_view listener) {
  return listener == "modbus" || listener == "modbus_tls";
}

std::span<const std::uint8_t> bytes_of(const std::string& data) {
  return {reinterpret_cast<const std::uint8_t*>(data.data()), data.size()};
}

/// "speed", or "0x8002" where the map has no name for it.
std::string register_name(modbus::Area area, unsigned address, bool conveyor) {
  if (!conveyor) return fmt::format("0x{:04x}", address);
  const auto* info = modbus::find_register(area, static_cast<std::uint16_t>(address));
  if (info == nullptr || info->span() > 1) return fmt::format("0x{:04x}", address);
  return std::string(info->name);
}

/// The addresses of a server that a scene describes, whose map a trace does not have.
class AnyAddress final : public modbus::AddressSpace {
 public:
  [[nodiscard]] bool has(modbus::Area /*area*/, std::uint16_t /*address*/, std::uint16_t /*count*/,
                         bool /*write*/) const override {
    return true;
  }
};

std::string read_text(modbus::Area area, unsigned address, unsigned quantity) {
  static constexpr const char* kAreas[] = {"coils", "discrete inputs", "input registers",
                                           "holding registers"};
  return fmt::format("{} 0x{:04x} to 0x{:04x}", kAreas[static_cast<std::size_t>(area)], address,
                     address + quantity - 1);
}

Action write_action(const modbus::Request& request, bool conveyor) {
  const modbus::Area area = modbus::area_of(request.function);
  Action action;
  action.kind = "write " + register_name(area, request.address, conveyor);
  if (request.quantity > 1) {
    action.kind += " to " + register_name(area, request.address + request.quantity - 1U, conveyor);
  }
  const auto add = [&](const std::string& name, double value) {
    action.fields.push_back({name, Number{Quantity::kCount, value}});
  };
  if (request.function == modbus::Function::kMaskWriteRegister) {
    action.kind = "mask " + register_name(area, request.address, conveyor);
    add("and-mask", request.word(0));
    add("or-mask", request.word(1));
    return action;
  }
  for (std::uint16_t i = 0; i < request.quantity; ++i) {
    const std::string name = register_name(area, request.address + unsigned{i}, conveyor);
    add(name, request.is_coil_write() ? (request.bit(i) ? 1 : 0) : request.word(i));
  }
  return action;
}

/// A request that has no answer yet.
struct OpenRequest {
  std::vector<std::uint8_t> pdu;
  std::optional<std::size_t> action;  ///< absent = a read, which is no action
};

/// Whether a reply can be the answer to a request: by its function code, and by what the protocol
/// repeats of the request (MODBUS Application Protocol V1.1b3, section 6).
bool answers(std::span<const std::uint8_t> request, std::span<const std::uint8_t> reply) {
  if (request.empty() || reply.empty() || (reply[0] & 0x7FU) != request[0]) return false;
  if ((reply[0] & 0x80U) != 0 || request.size() < 5) return true;
  const auto word = [&](std::size_t at) { return request[at] * 256U + request[at + 1]; };
  const auto repeats = [&](std::size_t count) {
    return reply.size() >= count && request.size() >= count &&
           std::ranges::equal(reply.first(count), request.first(count));
  };
  switch (request[0]) {
    case 1:
    case 2:
      return reply.size() >= 2 && reply[1] == (word(3) + 7) / 8;
    case 3:
    case 4:
    case 23:
      return reply.size() >= 2 && reply[1] == 2 * word(3);
    case 5:
    case 6:
    case 15:
    case 16:
      return repeats(5);
    case 22:
      return repeats(7);
    default:
      return true;
  }
}

/// Reads the requests and replies of one PLC.
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
    std::optional<Action> action = read(adu, is_conveyor(record.wire.listener()));
    if (adu.size() > modbus::kHeaderSize) {
      const auto pdu = adu.subspan(modbus::kHeaderSize);
      open_[transaction_of(record, adu)].push_back(
          {{pdu.begin(), pdu.end()}, action ? std::optional(out_.actions.size()) : std::nullopt});
    }
    if (!action) return;
    action->time_s = record.time_s;
    out_.actions.push_back(*std::move(action));
  }

  /// Counts a read; the action of any other request.
  std::optional<Action> read(std::span<const std::uint8_t> adu, bool conveyor) {
    static const AnyAddress any;
    const auto validated = modbus::validate_request(adu, {.addresses = conveyor ? nullptr : &any});
    if (validated.verdict == modbus::Verdict::kIdentification) {
      ++out_.polls;
      ++out_.reads["the device's identification"];
      return std::nullopt;
    }
    if (validated.verdict != modbus::Verdict::kRequest) {
      Action action{.kind = "wrong request"};
      std::string hex;
      // Without the transaction's number, which differs from run to run.
      for (const std::uint8_t byte : adu.subspan(std::min<std::size_t>(2, adu.size()))) {
        hex += fmt::format("{:02x} ", byte);
      }
      action.fields.push_back({"bytes", hex});
      return action;
    }
    const modbus::Request& request = validated.request;
    if (!request.is_write()) {
      ++out_.polls;
      ++out_.reads[read_text(modbus::area_of(request.function), request.address, request.quantity)];
      return std::nullopt;
    }
    if (request.function == modbus::Function::kReadWriteRegisters) {
      ++out_.reads[read_text(modbus::Area::kHoldingRegister, request.read_address,
                             request.read_quantity)];
    }
    return write_action(request, conveyor);
  }

  /// Clients may use one transaction number for every request: the reply belongs to the oldest
  /// request of its number that it can answer. Those before it stay without an answer, as a server
  /// replies in order.
  void reply(const WireRecord& record, std::span<const std::uint8_t> adu) {
    if (adu.size() <= modbus::kHeaderSize) return;
    const auto pdu = adu.subspan(modbus::kHeaderSize);
    const auto open = open_.find(transaction_of(record, adu));
    if (open == open_.end()) return;
    auto& requests = open->second;
    const auto answered = std::ranges::find_if(
        requests, [&](const OpenRequest& request) { return answers(request.pdu, pdu); });
    if (answered == requests.end()) return;
    if (answered->action) {
      Action& action = out_.actions[*answered->action];
      const bool refused = (pdu[0] & 0x80U) != 0;
      action.outcome = !refused ? "done" : fmt::format("exception {}", pdu.size() > 1 ? pdu[1] : 0);
      action.duration_s = record.time_s - action.time_s;
    }
    requests.erase(requests.begin(), std::next(answered));
    if (requests.empty()) open_.erase(open);
  }

  std::map<Transaction, std::deque<OpenRequest>> open_;  ///< in the order of sending
  WireActions out_;
};

}  // namespace

WireActions modbus_actions(const Records& records) {
  ModbusReader reader;
  for (const WireRecord* record : records) reader.take(*record);
  return reader.take_result();
}

}  // namespace aprsim::trace
