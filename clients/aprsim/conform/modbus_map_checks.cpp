#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clients/aprsim/conform/modbus_check_groups.hpp"
#include "clients/aprsim/conform/modbus_probe.hpp"
#include "modbus/conformance_cases.hpp"
#include "modbus/request.hpp"

namespace aprsim::client::conform {
namespace {

using modbus::Area;
using modbus::conformance::Bytes;
using modbus::conformance::pdu;
using modbus::conformance::section_of;
using modbus::conformance::write_many;

constexpr const char* kClause = "MODBUS Application Protocol V1.1b3, ";

std::string exception_to(const Target& target, const Bytes& request, int code) {
  ModbusProbe probe(target);
  const Bytes reply = probe.ask(request);
  const Bytes expected{static_cast<std::uint8_t>(request.front() | 0x80U),
                       static_cast<std::uint8_t>(code)};
  expect(reply == expected, in_hex(reply));
  return in_hex(reply);
}

/// Adds the checks of one server's map under numbers of their own.
class MapChecks {
 public:
  MapChecks(const ModbusShape& shape, std::vector<Check>& checks)
      : shape_(shape), checks_(checks) {}

  void add_all() {
    add_reads(1, Area::kCoil, modbus::kMaxReadBits);
    add_reads(2, Area::kDiscreteInput, modbus::kMaxReadBits);
    add_reads(3, Area::kHoldingRegister, modbus::kMaxReadRegisters);
    add_reads(4, Area::kInputRegister, modbus::kMaxReadRegisters);
    add_coil_writes();
    add_register_writes();
    add_refused_writes();
  }

 private:
  void rule(std::uint8_t function, const std::string& text, const std::string& expected,
            bool writes, std::function<std::string(const Target&)> run) {
    checks_.push_back({fmt::format("M{}", ++number_), kClause + section_of(function),
                       fmt::format("FC {}: {}", function, text), expected, writes, std::move(run)});
  }
  void refused(const Bytes& request, int code, const std::string& text, bool writes = false) {
    rule(request.front(), text, fmt::format("exception {}", code), writes,
         [request, code](const Target& target) { return exception_to(target, request, code); });
  }

  void add_reads(std::uint8_t function, Area area, std::uint16_t limit) {
    if (const auto run = shape_.longest(area, false)) {
      const std::uint16_t most = std::min(run->count, limit);
      for (const std::uint16_t count : std::set<std::uint16_t>{1, most}) {
        rule(function, fmt::format("{} from {} on", count, run->address),
             fmt::format("values: {}", count), false,
             [function, run = *run, count](const Target& target) {
               ModbusProbe probe(target);
               return fmt::format("values: {}", probe.words(function, run.address, count).size());
             });
      }
      if (run->count < limit && run->address + run->count <= 0xFFFF) {
        const auto beyond = static_cast<std::uint16_t>(run->count + 1);
        refused(pdu(function, {run->address, beyond}), 2, "one address too far");
      }
      refused(pdu(function, {run->address, 0}), 3, "none");
      refused(pdu(function, {run->address, static_cast<std::uint16_t>(limit + 1)}), 3,
              "more than a reply holds");
    }
    if (const auto missing = shape_.missing(area, false)) {
      refused(pdu(function, {*missing, 1}), 2, fmt::format("{}, which is not there", *missing));
      refused(pdu(function, {*missing, 0}), 3, "none of what is not there");
    }
    refused(pdu(function, {0xFFFF, 2}), 2, "beyond the last address");
    refused(Bytes{function, 0, 0, 0}, 3, "a byte less");
    refused(Bytes{function, 0, 0, 0, 1, 0}, 3, "a byte more");
  }

  /// Each value is written as it was read, so that nothing moves but by a server that is wrong.
  void add_coil_writes() {
    const auto run = shape_.longest(Area::kCoil, true);
    if (!run) return;
    rule(5, fmt::format("the present value of {}", run->address), "its echo", true,
         [run = *run](const Target& target) {
           ModbusProbe probe(target);
           const bool on = probe.value(1, run.address) == 1;
           return echoed(probe, pdu(5, {run.address, static_cast<std::uint16_t>(on ? 0xFF00 : 0)}));
         });
    rule(15, "the present value of some", "the address and the number", true,
         [run = *run](const Target& target) {
           ModbusProbe probe(target);
           const std::uint16_t count = std::min<std::uint16_t>(run.count, 9);
           Bytes data((count + 7U) / 8U);
           const auto bits = probe.words(1, run.address, count);
           for (std::size_t i = 0; i < bits.size(); ++i) {
             data[i / 8] = static_cast<std::uint8_t>(data[i / 8] | bits[i] << (i % 8));
           }
           return echoed(probe, write_many(15, run.address, count,
                                           static_cast<std::uint8_t>(data.size()), data));
         });
    refused(pdu(5, {run->address, 1}), 3, "neither 0000 nor FF00", true);
    refused(write_many(15, run->address, 1, 2, {0, 0}), 3, "another byte count", true);
    refused(write_many(15, run->address, 0, 0, {}), 3, "none", true);
  }

  void add_register_writes() {
    const auto run = shape_.longest(Area::kHoldingRegister, true);
    if (!run) return;
    rule(6, fmt::format("the present value of {}", run->address), "its echo", true,
         [run = *run](const Target& target) {
           ModbusProbe probe(target);
           return echoed(probe, pdu(6, {run.address, probe.value(3, run.address)}));
         });
    rule(16, "the present values of some", "the address and the number", true,
         [run = *run](const Target& target) {
           ModbusProbe probe(target);
           const std::uint16_t count = std::min<std::uint16_t>(run.count, 100);
           const auto words = probe.words(3, run.address, count);
           return echoed(probe, modbus::conformance::write_words(run.address, words));
         });
    rule(22, fmt::format("no bit of {}", run->address), "its echo", true,
         [run = *run](const Target& target) {
           ModbusProbe probe(target);
           return echoed(probe, pdu(22, {run.address, 0xFFFF, 0}));
         });
    rule(23, fmt::format("the present value of {}", run->address), "the same", true,
         [run = *run](const Target& target) {
           ModbusProbe probe(target);
           const std::uint16_t value = probe.value(3, run.address);
           Bytes request = pdu(23, {run.address, 1, run.address, 1});
           request.push_back(2);
           request.push_back(static_cast<std::uint8_t>(value >> 8));
           request.push_back(static_cast<std::uint8_t>(value & 0xFF));
           const Bytes reply = probe.ask(request);
           expect(reply.size() == 4 && reply[0] == 23 && reply[1] == 2, in_hex(reply));
           expect((reply[2] << 8 | reply[3]) == value, in_hex(reply));
           return in_hex(reply);
         });
    refused(write_many(16, run->address, 1, 3, {0, 0, 0}), 3, "another byte count", true);
    refused(write_many(16, run->address, 0, 0, {}), 3, "none", true);
    refused(pdu(22, {run->address, 0}), 3, "a word less", true);
  }

  void add_refused_writes() {
    for (const auto& [function, area, value] :
         {std::tuple{std::uint8_t{5}, Area::kCoil, std::uint16_t{0}},
          std::tuple{std::uint8_t{6}, Area::kHoldingRegister, std::uint16_t{0}}}) {
      if (const auto missing = shape_.missing(area, false)) {
        refused(pdu(function, {*missing, value}), 2, "what is not there", true);
      }
      if (const auto reading = shape_.only_read(area)) {
        refused(pdu(function, {*reading, value}), 2, "what is only read", true);
      }
    }
  }

  static std::string echoed(ModbusProbe& probe, const Bytes& request) {
    const Bytes reply = probe.ask(request);
    const std::size_t size = request.front() == 22 ? 7 : 5;
    expect(reply.size() == size && std::equal(reply.begin(), reply.end(), request.begin()),
           in_hex(reply));
    return in_hex(reply);
  }

  const ModbusShape& shape_;
  std::vector<Check>& checks_;
  int number_ = 0;
};

}  // namespace

std::vector<std::uint8_t> some_read(const ModbusShape& shape, std::uint16_t most) {
  std::uint8_t function = 1;
  for (const Area area :
       {Area::kCoil, Area::kDiscreteInput, Area::kHoldingRegister, Area::kInputRegister}) {
    if (const auto run = shape.longest(area, false))
      return pdu(function, {run->address, std::min(run->count, most)});
    ++function;
  }
  return pdu(3, {0, 1});
}

std::vector<Check> modbus_map_checks(const ModbusShape& shape) {
  std::vector<Check> checks;
  frames::add(checks);
  MapChecks(shape, checks).add_all();
  return checks;
}

}  // namespace aprsim::client::conform
