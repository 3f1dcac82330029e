#include <algorithm>
#include <cctype>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "clients/aprsim/conform/belt_settings.hpp"
#include "clients/aprsim/conform/modbus_check_groups.hpp"
#include "clients/aprsim/conform/modbus_probe.hpp"
#include "modbus/conformance_cases.hpp"

namespace aprsim::client::conform::functions {
namespace {

using modbus::conformance::Bytes;
using modbus::conformance::ConformanceCase;
using modbus::conformance::kAccepted;

constexpr const char* kProtocol = "MODBUS Application Protocol V1.1b3, ";

// "Fc3OneTooMany" as "FC 3: one too many".
std::string in_words(const std::string& name) {
  std::string out = "FC ";
  std::size_t i = 2;
  while (i < name.size() && std::isdigit(static_cast<unsigned char>(name[i])) != 0) {
    out += name[i++];
  }
  out += ':';
  for (; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    if (std::isupper(c) != 0) out += ' ';
    out += static_cast<char>(std::tolower(c));
  }
  return out;
}

// Whether a case writes. On a wrong server, a request that hides a second one may write, too.
bool writes(const ConformanceCase& one) {
  const std::uint8_t function = one.pdu.front();
  const bool hides = one.name.ends_with("HiddenWriteBehind");
  return hides || (function != 43 && function > 4);
}

std::string ask(const Target& target, const ConformanceCase& one) {
  std::optional<BeltSettings> kept;
  if (writes(one)) kept.emplace(target);
  ModbusProbe probe(target);
  const Bytes reply = probe.ask(one.pdu);
  const std::uint8_t function = one.pdu.front();
  if (one.exception != kAccepted) {
    const Bytes expected{static_cast<std::uint8_t>(function | 0x80U),
                         static_cast<std::uint8_t>(one.exception)};
    if (reply != expected) throw NotKept{in_hex(reply)};
    return in_hex(reply);
  }
  if (reply.empty() || reply.front() != function) throw NotKept{in_hex(reply)};
  // A read has its byte count; a write repeats its request, whole or without its data.
  const auto quantity = static_cast<std::size_t>(one.pdu[3] << 8 | one.pdu[4]);
  const bool reads = function < 5 || function == 23;
  const std::size_t data = function < 3 ? (quantity + 7) / 8 : 2 * quantity;
  const std::size_t echoed = function == 22 ? 7 : 5;
  const bool right =
      reads ? reply.size() == data + 2 && reply[1] == data
            : reply.size() == echoed && std::equal(reply.begin(), reply.end(), one.pdu.begin());
  if (!right) throw NotKept{in_hex(reply)};
  return in_hex(reply);
}

std::string unknown(const Target& target) {
  ModbusProbe probe(target);
  for (const int code : {9, 10, 13, 18, 19, 25, 65, 72, 100, 110, 127}) {
    const Bytes reply = probe.ask(Bytes{static_cast<std::uint8_t>(code), 0, 0});
    if (reply != Bytes{static_cast<std::uint8_t>(code | 0x80), 1}) {
      throw NotKept{fmt::format("FC {}: {}", code, in_hex(reply))};
    }
  }
  return "exception 1 to each of 11";
}

std::string identification(const Target& target) {
  ModbusProbe probe(target);
  const Bytes reply = probe.ask(Bytes{43, 14, 1, 0});
  if (reply.size() < 8 || reply[0] != 43 || reply[1] != 14 || reply[2] != 1 || reply[6] < 3) {
    throw NotKept{in_hex(reply)};
  }
  std::string names;
  std::size_t at = 7;
  for (int i = 0; i < reply[6]; ++i) {
    if (at + 2 > reply.size() || at + 2 + reply[at + 1] > reply.size()) {
      throw NotKept{in_hex(reply)};
    }
    const auto begin = reply.begin() + static_cast<std::ptrdiff_t>(at) + 2;
    names += (names.empty() ? "" : ", ") + std::string(begin, begin + reply[at + 1]);
    at += 2U + reply[at + 1];
  }
  return names;
}

}  // namespace

void add(std::vector<Check>& checks) {
  int number = 0;
  for (const ConformanceCase& one : modbus::conformance::conformance_cases()) {
    checks.push_back({fmt::format("FC{}", ++number), kProtocol + one.section, in_words(one.name),
                      one.exception == kAccepted ? std::string("done")
                                                 : fmt::format("exception {}", one.exception),
                      writes(one), [one](const Target& target) { return ask(target, one); }});
  }
  checks.push_back({fmt::format("FC{}", ++number), std::string(kProtocol) + "7",
                    "function codes that nobody has", "exception 1", false, unknown});
  checks.push_back({fmt::format("FC{}", ++number), std::string(kProtocol) + "6.21",
                    "FC 43/14: basic identification", "3 names", false, identification});
}

}  // namespace aprsim::client::conform::functions
