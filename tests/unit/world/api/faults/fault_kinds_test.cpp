#include "world/api/faults/fault_kinds.hpp"

#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "world/api/faults/fault_kinds_text.hpp"

namespace aprsim::faults {
namespace {

TEST(FaultKinds, HaveNamesOfTheirOwnAndParametersWithinTheirRanges) {
  std::set<std::string_view> names;
  for (const KindInfo& kind : all_kinds()) {
    EXPECT_TRUE(names.insert(kind.name).second) << kind.name;
    EXPECT_EQ(find(kind.name), &kind);
    EXPECT_EQ(&info(kind.kind), &kind);
    EXPECT_FALSE(kind.meaning.empty()) << kind.name;
    std::set<std::string_view> parameters;
    for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
      const Parameter& parameter = kind.parameters[i];
      EXPECT_TRUE(parameters.insert(parameter.name).second) << kind.name << parameter.name;
      EXPECT_EQ(kind.parameter(parameter.name), i);
      EXPECT_LT(parameter.min, parameter.max) << kind.name << parameter.name;
      EXPECT_GE(parameter.fallback, parameter.min) << kind.name << parameter.name;
      EXPECT_LE(parameter.fallback, parameter.max) << kind.name << parameter.name;
      EXPECT_FALSE(parameter.unit.empty() || parameter.meaning.empty()) << kind.name;
    }
  }
  EXPECT_GE(names.size(), 30U);
  EXPECT_EQ(find("gremlins"), nullptr);
  EXPECT_FALSE(info(Kind::kBeltJam).parameter(""));
}

TEST(FaultKinds, AreInTheDocumentAsTheyAre) {
  std::ifstream in(std::string(APRSIM_SOURCE_DIR) + "/world/api/faults/FAULTS.md");
  const std::string text(std::istreambuf_iterator<char>(in), {});
  EXPECT_EQ(text, markdown())
      << "renew it: aprsim fault kinds --markdown > world/api/faults/FAULTS.md";
}

}  // namespace
}  // namespace aprsim::faults
