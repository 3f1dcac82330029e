// The built-in schemas: they allow what we write and what the language has, and nothing else.

#include "crcl/schema.hpp"

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "crcl/command_codec.hpp"
#include "crcl/status_codec.hpp"
#include "tests/unit/crcl/every_command.hpp"
#include "tests/unit/crcl/golden.hpp"
#include "tests/unit/crcl/samples.hpp"
#include "tests/unit/crcl/schema_facts.hpp"

namespace aprsim::crcl {
namespace {

namespace fs = std::filesystem;

std::string fault(const std::string& document) {
  const auto found = schema_fault(document);
  return found ? found->message() : "";
}

std::vector<std::string> built_in() {
  std::vector<std::string> texts;
  for (const SchemaFile& file : schema_files()) texts.emplace_back(file.text);
  return texts;
}

TEST(Schema, AllowsEveryGoldenDocument) {
  int checked = 0;
  for (const auto& entry :
       fs::directory_iterator(fs::path(APRSIM_SOURCE_DIR) / "tests/contract/crcl")) {
    if (entry.path().extension() != ".xml") continue;
    EXPECT_EQ(fault(read_file(entry.path())), "") << entry.path();
    ++checked;
  }
  EXPECT_GE(checked, 40);
}

TEST(Schema, AllowsEveryCommandAndStatusThatWeWrite) {
  for (const auto& [name, instance] : every_command()) {
    EXPECT_EQ(fault(encode_command(instance)), "") << name;
  }
  EXPECT_EQ(fault(encode_status(full_status())), "");
}

TEST(Schema, RefusesWhatTheLanguageHasNot) {
  const std::string bad[] = {
      with_id("SetEndEffectorType", "<Setting>1.5</Setting>"),
      with_id("SetEndEffectorType", ""),
      with_id("SetEndEffectorType", "<Setting>1</Setting><Extra/>"),
      with_id("SetLengthUnitsType", "<UnitName>feet</UnitName>"),
      with_id("MoveThroughToType",
              "<MoveStraight>true</MoveStraight><NumPositions>0</NumPositions>"),
      with_id("FlyType", ""),
      instance("InitCanonType", ""),
      instance("CRCLCommandType", "<CommandID>1</CommandID>"),
      "<CRCLProgram><InitCanon><CommandID>1</CommandID></InitCanon></CRCLProgram>",
      "<CRCLStatus></CRCLStatus>",
      "<Other/>",
      "<!DOCTYPE CRCLStatus><CRCLStatus/>",
      "<CRCLStatus",
      "",
  };
  for (const std::string& document : bad) EXPECT_NE(fault(document), "") << document;
}

TEST(Schema, IgnoresHintsToOtherSchemas) {
  std::string document = with_id("SetEndEffectorType", "<Setting>1.5</Setting>");
  document.replace(0, std::string("<CRCLCommandInstance").size(),
                   "<CRCLCommandInstance xmlns:x='http://www.w3.org/2001/XMLSchema-instance' "
                   "x:noNamespaceSchemaLocation='http://127.0.0.1:1/none.xsd'");
  EXPECT_NE(fault(document).find("1.5"), std::string::npos) << fault(document);
}

TEST(Schema, HasExactlyTheCommandsThatWeReadAndWrite) {
  std::set<std::string> declared, written;
  for (const auto& [what, facts] : schema_facts(built_in())) {
    const bool command = facts.starts_with("extends MiddleCommandType") ||
                         facts.starts_with("extends CRCLCommandType");
    if (command && !facts.ends_with("abstract"))
      declared.insert(what.substr(std::string("complexType ").size()));
  }
  for (const auto& [name, instance] : every_command()) {
    written.insert(std::string(type_name(instance.command.body)));
  }
  EXPECT_EQ(declared, written);
  EXPECT_EQ(declared.size(), 38U);
}

TEST(Schema, DeclaresWhatTheReferenceDeclares) {
  const fs::path xsd = fs::path(APRSIM_REFERENCE_DIR) / "crcl/xsd";
  if (std::string(APRSIM_REFERENCE_DIR).empty()) {
    GTEST_SKIP() << "no reference material: APRSIM_REFERENCE_DIR is not set";
  }
  std::vector<std::string> reference;
  for (const auto& entry : fs::directory_iterator(xsd)) {
    if (entry.path().extension() == ".xsd") reference.push_back(read_file(entry.path()));
  }
  EXPECT_EQ(reference.size(), 5U);
  const auto ours = schema_facts(built_in()), theirs = schema_facts(reference);
  EXPECT_GT(theirs.size(), 100U);
  for (const auto& [what, facts] : theirs) {
    const auto found = ours.find(what);
    EXPECT_EQ(found == ours.end() ? "nothing" : found->second, facts) << what;
  }
  for (const auto& [what, facts] : ours) EXPECT_TRUE(theirs.contains(what)) << what;
}

}  // namespace
}  // namespace aprsim::crcl
