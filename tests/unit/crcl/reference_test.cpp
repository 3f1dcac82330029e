// Tests against the reference material, where present: its samples are read, and the documents that
// aprsim writes are valid by its schemas.

#include <algorithm>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "crcl/command_codec.hpp"
#include "crcl/status_codec.hpp"
#include "crcl/text.hpp"
#include "crcl/xml_reader.hpp"
#include "tests/unit/crcl/golden.hpp"
#include "tests/unit/crcl/samples.hpp"
#include "tests/unit/crcl/schema_validator.hpp"

namespace aprsim::crcl {
namespace {

namespace fs = std::filesystem;

// Whether `ours` says what `theirs` does: the same elements in the same order with the same values.
// Not looked at: names of parts of a status, which say nothing, and numbers' spelling.
std::string difference(const XmlNode& ours, const XmlNode& theirs, const std::string& path) {
  const auto parts_of = [&path](const XmlNode& node) {
    std::vector<const XmlNode*> parts;
    const bool named = path.empty() || node.name == "CommandStatus" || node.name == "Guard";
    for (const XmlNode& part : node.children) {
      if (part.name != "Name" || named) parts.push_back(&part);
    }
    return parts;
  };
  const std::string here = path + "/" + theirs.name;
  if (ours.name != theirs.name) return here + " is " + ours.name;
  if (ours.type != theirs.type) return here + " has the type " + ours.type;
  const auto ours_in = parts_of(ours), theirs_in = parts_of(theirs);
  if (ours_in.size() != theirs_in.size()) return here + " has another number of elements";
  for (std::size_t i = 0; i < ours_in.size(); ++i) {
    const std::string found = difference(*ours_in[i], *theirs_in[i], here);
    if (!found.empty()) return found;
  }
  if (!theirs_in.empty() || trim(ours.text) == trim(theirs.text)) return "";
  const auto number = parse_double(theirs.text);
  if (number && number == parse_double(ours.text)) return "";
  return here + " is " + ours.text;
}

class Reference : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(APRSIM_REFERENCE_DIR) / "crcl";
    if (std::string(APRSIM_REFERENCE_DIR).empty()) {
      GTEST_SKIP() << "no reference material: APRSIM_REFERENCE_DIR is not set";
    }
  }

  [[nodiscard]] std::vector<fs::path> samples(const std::string& kind) const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(root_ / "samples" / kind)) {
      files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    EXPECT_FALSE(files.empty());
    return files;
  }

  [[nodiscard]] SchemaValidator validator(const std::string& schema) const {
    return SchemaValidator((root_ / "xsd" / schema).string());
  }

  fs::path root_;
};

TEST_F(Reference, EveryCommandSampleIsReadAndWrittenValidly) {
  const SchemaValidator schema = validator("CRCLCommandInstance.xsd");
  for (const fs::path& file : samples("CRCLCommandInstance")) {
    const Result<CommandInstance> instance = decode_command(read_file(file));
    ASSERT_TRUE(instance) << file << ": " << instance.error().message();
    const std::string written = encode_command(*instance);
    EXPECT_EQ(schema.fault(written), "") << file << "\n" << written;
    EXPECT_EQ(decode_command(written).value(), *instance) << file;
  }
}

TEST_F(Reference, EveryCommandOfEveryProgramSampleIsReadAndWrittenValidly) {
  const SchemaValidator schema = validator("CRCLCommandInstance.xsd");
  for (const fs::path& file : samples("CRCLProgram")) {
    const Result<Program> program = decode_program(read_file(file));
    ASSERT_TRUE(program) << file << ": " << program.error().message();
    EXPECT_GE(program->commands.size(), 2U) << file;
    for (const Command& command : program->commands) {
      const std::string written = encode_command({{}, command, {}, {}, {}});
      EXPECT_EQ(schema.fault(written), "") << file << "\n" << written;
      EXPECT_EQ(decode_command(written).value().command, command) << file;
    }
  }
}

// One sample lacks what the schema asks of every sensor; there is nothing to compare.
TEST_F(Reference, EveryStatusSampleIsWrittenAsItWas) {
  for (const fs::path& file : samples("CRCLStatus")) {
    if (file.filename().string().ends_with("forceTorqueStatusExample.xml")) continue;
    const std::string theirs = read_file(file);
    const std::string ours = encode_status(decode_status(theirs).value());
    EXPECT_EQ(difference(parse_xml(ours).value(), parse_xml(theirs).value(), ""), "") << file;
  }
}

TEST_F(Reference, EveryStatusSampleIsReadAndWrittenValidly) {
  const SchemaValidator schema = validator("CRCLStatus.xsd");
  for (const fs::path& file : samples("CRCLStatus")) {
    const Result<Status> status = decode_status(read_file(file));
    ASSERT_TRUE(status) << file << ": " << status.error().message();
    const std::string written = encode_status(*status);
    EXPECT_EQ(schema.fault(written), "") << file << "\n" << written;
    EXPECT_EQ(decode_status(written).value(), *status) << file;
  }
}

TEST_F(Reference, OurGoldenDocumentsAreValid) {
  const SchemaValidator commands = validator("CRCLCommandInstance.xsd");
  const SchemaValidator statuses = validator("CRCLStatus.xsd");
  int checked = 0;
  for (const auto& entry :
       fs::directory_iterator(fs::path(APRSIM_SOURCE_DIR) / "tests/contract/crcl")) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(".xml")) continue;
    const SchemaValidator& schema = name.starts_with("status_") ? statuses : commands;
    EXPECT_EQ(schema.fault(read_file(entry.path())), "") << name;
    ++checked;
  }
  EXPECT_GE(checked, 29);
}

TEST_F(Reference, TheSchemaTellsValidFromInvalid) {
  const SchemaValidator schema = validator("CRCLStatus.xsd");
  EXPECT_EQ(schema.fault(encode_status(full_status())), "");
  EXPECT_NE(schema.fault("<CRCLStatus></CRCLStatus>"), "");
}

}  // namespace
}  // namespace aprsim::crcl
