#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "clients/wires/outcome.hpp"

namespace aprsim::client {
struct Console;
}

/// What is checked of somebody's server, rule by rule.
namespace aprsim::client::conform {

/// The server that is looked at.
struct Target {
  std::string host;
  std::uint16_t port = 0;
  bool allow_motion = false;  ///< something may move, a little
  std::string sensor;         ///< that guards of a robot can watch; empty = one of the known names
};

/// Thrown by a check whose rule is not kept, with what was seen.
struct NotKept {
  std::string seen;
};
/// Throws it with what was seen unless it is so.
void expect(bool so, const std::string& seen);
/// Thrown by a check of what the server need not have: why it is not made.
struct NotApplicable {
  std::string why;
};
/// Thrown by a check that cannot go on, and with it all others: interrupted, or nobody there.
struct GivenUp {
  Failure failure;
};

struct Check {
  std::string clause;    ///< "C3.2"
  std::string source;    ///< where the rule is written
  std::string what;      ///< is checked
  std::string expected;  ///< by the rule
  bool moves = false;    ///< something may move: made only when allowed
  /// Returns what was seen when the rule is kept.
  std::function<std::string(const Target&)> look;
};

enum class Verdict { kPass, kFail, kNotChecked };

struct Finding {
  const Check* check = nullptr;
  Verdict verdict = Verdict::kNotChecked;
  std::string seen;
};

/// Makes all checks in their order, each told to `tell` when it is over. The failure of one that
/// cannot go on.
[[nodiscard]] Outcome<std::vector<Finding>> run_checks(
    const std::vector<Check>& checks, const Target& target,
    const std::function<void(const Finding&)>& tell);

/// "pass", "fail" or "not checked".
[[nodiscard]] std::string_view name_of(Verdict verdict);

/// Makes all checks and shows what came of each, and the score. kCheck when a rule is not kept.
[[nodiscard]] Outcome<void> check_server(const std::vector<Check>& checks, const Target& target,
                                         Console& console);

/// The rules as a page: a table of clauses with where they are written.
[[nodiscard]] std::string clauses_page(const std::string& heading,
                                       const std::vector<Check>& checks);

/// The checks of a robot's CRCL server.
[[nodiscard]] std::vector<Check> crcl_checks();
/// The checks of the conveyor's Modbus server.
[[nodiscard]] std::vector<Check> modbus_checks();

}  // namespace aprsim::client::conform
