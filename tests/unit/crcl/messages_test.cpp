// The language as protobuf: what a document says, its message says, and the other way round.

#include "crcl/messages.hpp"

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include "crcl/command_codec.hpp"
#include "crcl/schema.hpp"
#include "crcl/status_codec.hpp"
#include "crcl/text.hpp"
#include "crcl/xml_reader.hpp"
#include "tests/support/case_count.hpp"
#include "tests/unit/crcl/every_command.hpp"
#include "tests/unit/crcl/generated_documents.hpp"
#include "tests/unit/crcl/golden.hpp"
#include "tests/unit/crcl/samples.hpp"

namespace aprsim::crcl {
namespace {

namespace fs = std::filesystem;

// The document of the message of a document, by way of the bytes that go over a wire.
template <typename Message>
std::string through(const Result<Message>& message) {
  if (!message) return message.error().message();
  Message received;
  if (!received.ParseFromString(message->SerializeAsString())) return "not parsed";
  return to_document(received);
}

std::string through_message(const std::string& document) {
  const std::string root = parse_xml(document, {.max_bytes = kMaxProgramBytes}).value().name;
  if (root == "CRCLProgram") return through(program_message(document));
  if (root == "CRCLStatus") return through(status_message(document));
  return through(command_message(document));
}

// The first difference between two documents: elements, their order, types, or text. The spelling
// of numbers and truth values and the white space between elements do not count.
std::string loss(const XmlNode& ours, const XmlNode& theirs, const std::string& path = "") {
  const std::string here = path + "/" + theirs.name;
  if (ours.name != theirs.name) return here + " is " + ours.name;
  // A pose that says that it is one is a pose.
  if (ours.type != theirs.type && theirs.type != "PoseType") return here + " of type " + ours.type;
  if (ours.children.size() != theirs.children.size()) return here + " has other elements";
  for (std::size_t i = 0; i < ours.children.size(); ++i) {
    const std::string found = loss(ours.children[i], theirs.children[i], here);
    if (!found.empty()) return found;
  }
  if (!ours.children.empty() || ours.text == theirs.text) return "";
  const auto number = parse_double(theirs.text);
  if (number && number == parse_double(ours.text)) return "";
  const auto flag = parse_bool(theirs.text);
  if (flag && flag == parse_bool(ours.text)) return "";
  // Blanks around a word of an enumeration, or in an element that holds nothing.
  if (trim(ours.text) == trim(theirs.text) && trim(ours.text) == ours.text) return "";
  return here + " is " + ours.text + " and not " + theirs.text;
}

std::string loss(const std::string& ours, const std::string& theirs) {
  const XmlLimits limits{.max_bytes = kMaxProgramBytes};
  const Result<XmlNode> written = parse_xml(ours, limits);
  if (!written) return ours;
  return loss(*written, parse_xml(theirs, limits).value());
}

TEST(Messages, CarryEveryGoldenDocument) {
  int checked = 0;
  for (const auto& entry :
       fs::directory_iterator(fs::path(APRSIM_SOURCE_DIR) / "tests/contract/crcl")) {
    if (entry.path().extension() != ".xml") continue;
    const std::string document = golden(entry.path().filename().string());
    EXPECT_EQ(through_message(document), document) << entry.path();
    ++checked;
  }
  EXPECT_GE(checked, 40);
}

TEST(Messages, CarryEverySampleWithoutLoss) {
  if (std::string(APRSIM_REFERENCE_DIR).empty()) {
    GTEST_SKIP() << "no reference material: APRSIM_REFERENCE_DIR is not set";
  }
  int checked = 0;
  const fs::path samples = fs::path(APRSIM_REFERENCE_DIR) / "crcl/samples";
  for (const auto& entry : fs::recursive_directory_iterator(samples)) {
    if (entry.path().extension() != ".xml") continue;
    const std::string document = read_file(entry.path());
    EXPECT_EQ(loss(through_message(document), document), "") << entry.path();
    ++checked;
  }
  EXPECT_GE(checked, 60);
}

// Also through the C++ values: the same command, status or program, or the same refusal.
template <typename Value, typename Message>
void expect_same_values(const Result<Value>& read, const Result<Message>& message,
                        const std::string& document) {
  ASSERT_TRUE(message) << message.error().message() << "\n" << document;
  const Result<Value> value = from_message(*message);
  ASSERT_EQ(value.has_value(), read.has_value()) << document;
  if (!read) {
    EXPECT_EQ(value.error().message(), read.error().message()) << document;
    return;
  }
  EXPECT_TRUE(*value == *read) << document;
  const Result<Value> again = from_message(to_message(*read));
  EXPECT_TRUE(again && *again == *read) << document;
}

TEST(Messages, CarryGeneratedDocumentsWithoutLoss) {
  GeneratedDocuments generator;
  std::set<std::string> seen;
  unsigned understood = 0;
  const auto count = static_cast<unsigned>(test::case_count(10'000));
  for (unsigned i = 0; i < count; ++i) {
    const std::string document = generator.document(i);
    const std::string written = through_message(document);
    const std::string different = loss(written, document);
    ASSERT_EQ(different, "") << i << "\n" << document << "\n" << written;
    if (i % 50 < 3) {
      ASSERT_FALSE(schema_fault(document)) << schema_fault(document)->message() << document;
      ASSERT_FALSE(schema_fault(written)) << schema_fault(written)->message() << written;
    }
    if (i % 3 == 0) {
      const auto command = command_message(document);
      expect_same_values(decode_command(document), command, document);
      if (command) seen.insert(std::to_string(command->command().kind_case()));
      if (decode_command(document)) ++understood;
    } else if (i % 3 == 1) {
      expect_same_values(decode_status(document), status_message(document), document);
    } else {
      expect_same_values(decode_program(document), program_message(document), document);
    }
    if (HasFailure()) return;
  }
  EXPECT_EQ(seen.size(), 38U) << "kinds of commands";
  EXPECT_GT(understood, count / 10);
}

TEST(Messages, HaveEveryCommandAndStatusAsValues) {
  for (const auto& [name, instance] : every_command()) {
    const v1::CommandInstance message = to_message(instance);
    EXPECT_EQ(to_document(message), encode_command(instance)) << name;
    EXPECT_TRUE(from_message(message).value() == instance) << name;
  }
  EXPECT_EQ(to_document(to_message(full_status())), encode_status(full_status()));
  EXPECT_TRUE(from_message(to_message(full_status())).value() == full_status());
}

TEST(Messages, HaveProgramsAsValues) {
  const Program program{"p", {command(InitCanon{}), command(Dwell{1}), command(EndCanon{})}};
  EXPECT_TRUE(decode_program(encode_program(program)).value() == program);
  EXPECT_TRUE(from_message(to_message(program)).value() == program);
  EXPECT_EQ(to_document(to_message(program)), encode_program(program));
}

TEST(Messages, SayAsJsonWhatTheSchemaSays) {
  std::string json;
  ASSERT_TRUE(google::protobuf::util::MessageToJsonString(
                  to_message(CommandInstance{{}, command(Dwell{2.5}), {}, {}, {}}), &json)
                  .ok());
  EXPECT_EQ(json, R"({"CRCLCommand":{"CommandID":"7","DwellType":{"DwellTime":2.5}}})");
}

TEST(Messages, AreRefusedAsTheirDocumentsAre) {
  v1::CommandInstance message;
  EXPECT_EQ(from_message(message).error().kind, ErrorKind::kMalformed);
  message.mutable_command()->set_command_id(4);
  EXPECT_EQ(from_message(message).error().kind, ErrorKind::kMalformed) << "no kind of command";
  v1::MoveTo& move = *message.mutable_command()->mutable_move_to();
  v1::Pose& pose = *move.mutable_end_position();
  pose.mutable_point()->set_x(1);
  const Error error = from_message(message).error();
  EXPECT_EQ(error.kind, ErrorKind::kBadValue);
  EXPECT_EQ(error.command_type, "MoveToType");
  EXPECT_EQ(error.command_id, 4);
  EXPECT_EQ(error.element, "MoveToType/EndPosition/Point/Y");
  EXPECT_EQ(error.expected, "missing");
}

TEST(Messages, AreMadeOnlyOfWhatTheSchemaKnows) {
  const auto refused = [](const std::string& document) {
    const auto message = command_message(document);
    return message ? Error{} : message.error();
  };
  EXPECT_EQ(refused("<CRCLStatus/>").kind, ErrorKind::kMalformed);
  EXPECT_EQ(refused("<CRCLCommandInstance/>").element, "CRCLCommandInstance/CRCLCommand");
  EXPECT_EQ(refused(with_id("FlyType", "")).value, "FlyType");
  const Error number = refused(with_id("DwellType", "<DwellTime>long</DwellTime>"));
  EXPECT_EQ(number.kind, ErrorKind::kBadValue);
  EXPECT_EQ(number.element, "CRCLCommandInstance/CRCLCommand/DwellTime");
  EXPECT_EQ(number.value, "long");
  const Error unit = refused(with_id("SetLengthUnitsType", "<UnitName>feet</UnitName>"));
  EXPECT_EQ(unit.expected, "expected meter millimeter inch");
  // Unknown elements are ignored, as by all readers of the language.
  EXPECT_TRUE(command_message(with_id("InitCanonType", "<Extra><X>1</X></Extra>")));
}

}  // namespace
}  // namespace aprsim::crcl
