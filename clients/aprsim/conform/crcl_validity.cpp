#include <string>
#include <string_view>

#include <fmt/format.h>

#include "clients/aprsim/conform/crcl_check_groups.hpp"
#include "clients/aprsim/conform/crcl_probe.hpp"

namespace aprsim::client::conform::validity {
namespace {

// Expects that a command of that type with these elements is refused. None would cause motion if
// it were accepted.
auto refuses(std::string type, std::string elements) {
  return [type = std::move(type), elements = std::move(elements)](const Target& target) {
    const std::int64_t id = CrclProbe::next_id();
    return refused(target, command_document(type, id, elements), id);
  };
}

// The command has no id, so the error may have any.
std::string no_id(const Target& target) {
  return refused(target,
                 "<CRCLCommandInstance><CRCLCommand "
                 "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:type=\"DwellType\">"
                 "<CommandID>seven</CommandID><DwellTime>0</DwellTime></CRCLCommand>"
                 "</CRCLCommandInstance>",
                 std::nullopt);
}

// NIST's servers use JAXB and ignore unknown elements; a server that validates refuses them. The
// observation names which.
std::string unknown_element(const Target& target) {
  CrclProbe probe(target), other(target);
  probe.init();
  const std::int64_t id = CrclProbe::next_id();
  probe.send(command_document("MessageType", id, "<Message>m</Message><Wait>3</Wait>"));
  const SeenStatus seen = other.wait_error(id, CrclProbe::kAnswer);
  const std::string words = in_words(seen.status);
  const bool error = seen.status.command.state == crcl::CommandState::kError;
  const bool described = !seen.status.command.description.value_or("").empty();
  other.init();
  expect(!error || described, "an error without a description");
  return (error ? "strict: " : "lenient: ") + words;
}

}  // namespace

void add(std::vector<Check>& checks) {
  const auto rule = [&checks](const char* clause, const char* source, const char* text, auto run) {
    checks.push_back({clause, source, text, "CRCL_Error with a description, under its id or closed",
                      false, run});
  };
  constexpr const char* kCommands = "CRCLCommands.xsd";
  constexpr const char* kSchema = "XML Schema Part 2";
  rule("V1", kCommands, "a required element is missing", refuses("DwellType", ""));
  rule("V2", kSchema, "a number followed by other characters",
       refuses("DwellType", "<DwellTime>0.01s</DwellTime>"));
  rule("V3", kSchema, "an empty number", refuses("DwellType", "<DwellTime/>"));
  rule("V4", "duty of a robot", "a time that is not finite",
       refuses("DwellType", "<DwellTime>INF</DwellTime>"));
  rule("V5", kCommands, "an unknown unit",
       refuses("SetLengthUnitsType", "<UnitName>furlong</UnitName>"));
  rule("V6", kSchema, "an invalid boolean",
       refuses("ConfigureJointReportsType", "<ResetAll>maybe</ResetAll>"));
  rule("V7", kCommands, "too few of an element",
       refuses("MoveThroughToType",
               "<MoveStraight>true</MoveStraight><NumPositions>0</NumPositions>"));
  rule("V8", kSchema, "a CommandID that is not a number", no_id);
  rule("V9", "CRCLCommandInstance.xsd", "an instance without a command", [](const Target& t) {
    return refused(t, "<CRCLCommandInstance></CRCLCommandInstance>", std::nullopt);
  });
  checks.push_back({"V10", kCommands, "an element that the type does not have",
                    "left out, or CRCL_Error with a description", false, unknown_element});
}

}  // namespace aprsim::client::conform::validity
