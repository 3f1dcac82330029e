#include "clients/aprsim/conform/check.hpp"

#include <fmt/format.h>

namespace aprsim::client::conform {

void expect(bool so, const std::string& seen) {
  if (!so) throw NotKept{seen};
}

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPass:
      return "pass";
    case Verdict::kFail:
      return "fail";
    case Verdict::kNotChecked:
      break;
  }
  return "not checked";
}

Outcome<std::vector<Finding>> run_checks(const std::vector<Check>& checks, const Target& target,
                                         const std::function<void(const Finding&)>& report) {
  std::vector<Finding> findings;
  for (const Check& check : checks) {
    Finding finding{&check, Verdict::kNotChecked, "needs --allow-motion"};
    if (!check.moves || target.allow_motion) {
      try {
        finding.seen = check.run(target);
        finding.verdict = Verdict::kPass;
      } catch (const NotKept& unkept) {
        finding.seen = unkept.seen;
        finding.verdict = Verdict::kFail;
      } catch (const NotApplicable& none) {
        finding.seen = none.why;
      } catch (const GivenUp& given_up) {
        return tl::unexpected(given_up.failure);
      }
    }
    report(finding);
    findings.push_back(std::move(finding));
  }
  return findings;
}

std::string clauses_page(const std::string& heading, const std::vector<Check>& checks) {
  std::string out = fmt::format(
      "## {}\n\n| clause | check | expected | written in | moves |\n"
      "|---|---|---|---|---|\n",
      heading);
  for (const Check& check : checks) {
    out += fmt::format("| {} | {} | {} | {} | {} |\n", check.clause, check.text, check.expected,
                       check.source, check.moves ? "yes" : "");
  }
  return out;
}

}  // namespace aprsim::client::conform
