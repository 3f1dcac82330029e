#include <map>
#include <ostream>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/conform/check.hpp"

namespace aprsim::client::conform {
namespace {

std::string group_of(const Check& check) {
  return check.clause.substr(0, check.clause.find_first_of("0123456789"));
}

std::string row(const Finding& finding, const Paint& paint) {
  const Tone tone = finding.verdict == Verdict::kPass   ? Tone::kGood
                    : finding.verdict == Verdict::kFail ? Tone::kBad
                                                        : Tone::kWarning;
  const Check& check = *finding.check;
  return fmt::format("{:<5} {} {:<64} expected: {:<48} seen: {}\n", check.clause,
                     paint(tone, fmt::format("{:<11}", name_of(finding.verdict))), check.text,
                     check.expected, finding.seen);
}

nlohmann::ordered_json object(const Finding& finding) {
  const Check& check = *finding.check;
  return {{"clause", check.clause}, {"source", check.source},
          {"check", check.text},    {"expected", check.expected},
          {"seen", finding.seen},   {"verdict", name_of(finding.verdict)}};
}

struct Score {
  int passed = 0, failed = 0, not_checked = 0;

  void add(Verdict verdict) {
    (verdict == Verdict::kPass ? passed : verdict == Verdict::kFail ? failed : not_checked)++;
  }
  [[nodiscard]] int checked() const { return passed + failed; }
};

}  // namespace

Outcome<void> check_server(const std::vector<Check>& checks, const Target& target,
                           Console& console) {
  Score all;
  std::map<std::string, Score> groups;
  const auto findings = run_checks(checks, target, [&](const Finding& finding) {
    all.add(finding.verdict);
    groups[group_of(*finding.check)].add(finding.verdict);
    console.show(row(finding, console.screen.out), object(finding));
  });
  if (!findings) return tl::unexpected(findings.error());
  std::string text = "Score:";
  nlohmann::ordered_json by_group;
  for (const auto& [name, score] : groups) {
    text += fmt::format(" {} {}/{}", name, score.passed, score.checked());
    by_group[name] = {{"passed", score.passed}, {"checked", score.checked()}};
  }
  text += fmt::format("; {} of {} rules are kept", all.passed, all.checked());
  if (all.not_checked > 0) text += fmt::format(", {} not checked", all.not_checked);
  console.show(text + "\n", {{"host", target.host},
                             {"port", target.port},
                             {"passed", all.passed},
                             {"failed", all.failed},
                             {"not_checked", all.not_checked},
                             {"groups", by_group}});
  if (all.failed == 0) return {};
  return failed(FailureKind::kCheck,
                fmt::format("{} of {} rules are not kept", all.failed, all.checked()));
}

}  // namespace aprsim::client::conform
