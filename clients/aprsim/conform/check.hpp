#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/conform/modbus_shape.hpp"
#include "clients/wires/endpoints.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {
struct Console;
}

/// Conformance checks of any server, rule by rule.
namespace aprsim::client::conform {

/// The server under test.
struct Target {
  std::string host;
  std::uint16_t port = 0;
  std::optional<Encryption> encryption = {};  ///< of Modbus Security; absent = none
  bool allow_motion = false;                  ///< small motions are allowed
  std::string sensor;                         ///< force sensor for guards; empty = a known name
  /// Reads of one value and of many that a Modbus server has, from the function code on.
  std::vector<std::uint8_t> read_one = {3, 0x80, 0x00, 0, 1}, read_many = {3, 0x80, 0x00, 0, 125};
};

/// Thrown by a check for a violated rule, with the observation.
struct NotKept {
  std::string seen;
};
/// Throws it with the observation if the condition is false.
void expect(bool so, const std::string& seen);
/// Thrown by a check of an optional feature, with the reason for skipping it.
struct NotApplicable {
  std::string why;
};
/// Thrown by a check to end the whole test: interrupted, or no server.
struct GivenUp {
  Failure failure;
};

struct Check {
  std::string clause;    ///< "C3.2"
  std::string source;    ///< of the rule
  std::string text;      ///< description
  std::string expected;  ///< by the rule
  bool moves = false;    ///< causes motion: skipped unless allowed
  /// Returns the observation if the rule is kept.
  std::function<std::string(const Target&)> run;
};

enum class Verdict { kPass, kFail, kNotChecked };

struct Finding {
  const Check* check = nullptr;
  Verdict verdict = Verdict::kNotChecked;
  std::string seen;
};

/// Runs all checks in order and reports each to `report`. Failure: that of a check that ended the
/// test.
[[nodiscard]] Outcome<std::vector<Finding>> run_checks(
    const std::vector<Check>& checks, const Target& target,
    const std::function<void(const Finding&)>& report);

/// "pass", "fail" or "not checked".
[[nodiscard]] std::string_view name_of(Verdict verdict);

/// Runs all checks and shows each verdict and the score. Failure kCheck for a violated rule.
[[nodiscard]] Outcome<void> check_server(const std::vector<Check>& checks, const Target& target,
                                         Console& console);

/// The rules as a Markdown table of clauses and sources.
[[nodiscard]] std::string clauses_page(const std::string& heading,
                                       const std::vector<Check>& checks);

/// The checks of a robot's CRCL server.
[[nodiscard]] std::vector<Check> crcl_checks();
/// The checks of the conveyor's Modbus server.
[[nodiscard]] std::vector<Check> modbus_checks();
/// The checks of a Modbus server with these addresses.
[[nodiscard]] std::vector<Check> modbus_map_checks(const ModbusShape& shape);
/// A read of at most so many values of such a server, 1 to 125.
[[nodiscard]] std::vector<std::uint8_t> some_read(const ModbusShape& shape, std::uint16_t most);

}  // namespace aprsim::client::conform
