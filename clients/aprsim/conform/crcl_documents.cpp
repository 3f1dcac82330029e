#include <algorithm>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "clients/aprsim/conform/crcl_check_groups.hpp"
#include "clients/aprsim/conform/crcl_probe.hpp"
#include "crcl/schema.hpp"

namespace aprsim::client::conform::documents {
namespace {

constexpr Milliseconds kQuiet{300}, kClosing{3000};
constexpr const char* kClients = "NIST's Java clients";
constexpr const char* kXml = "XML 1.0";

// Sends bytes with a number of GetStatus commands and expects as many statuses.
std::string answered(const Target& target, const std::string& bytes, int count) {
  CrclProbe probe(target);
  probe.init();
  probe.send(bytes);
  for (int i = 0; i < count; ++i) (void)probe.read();
  expect(probe.silent(kQuiet), fmt::format("more than {} statuses", count));
  return count == 1 ? "1 status" : fmt::format("{} statuses", count);
}

// Sends a document with a Message of that id, and expects it to be done.
std::string done(const Target& target, std::int64_t id, const std::string& document) {
  CrclProbe probe(target);
  probe.init();
  probe.send(document);
  const SeenStatus seen = probe.wait_over(id, CrclProbe::kAnswer);
  expect(seen.status.command.state == crcl::CommandState::kDone, in_words(seen.status));
  return in_words(seen.status);
}

std::string split_character(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  const std::int64_t id = CrclProbe::next_id();
  const std::string document = command_document("MessageType", id, "<Message>\xC3\xA4</Message>");
  const std::size_t middle = document.find('\xA4');
  probe.send(document.substr(0, middle));
  expect(probe.silent(kQuiet), "an answer to half a document");
  probe.send(document.substr(middle));
  const SeenStatus seen = probe.wait_over(id, CrclProbe::kAnswer);
  expect(seen.status.command.state == crcl::CommandState::kDone, in_words(seen.status));
  return in_words(seen.status);
}

std::string bytewise(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  for (const char byte : get_status_document()) probe.send(std::string(1, byte));
  (void)probe.read();
  expect(probe.silent(kQuiet), "more than 1 status");
  return "1 status";
}

std::string half(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  const std::string document = get_status_document();
  probe.send(document.substr(0, document.size() / 2));
  expect(probe.silent(kQuiet), "an answer to half a document");
  probe.send(document.substr(document.size() / 2));
  (void)probe.read();
  return "1 status, after the rest";
}

// The connection is closed; others continue, with an error that InitCanon clears.
std::string closes(const Target& target, const std::string& document) {
  CrclProbe other(target);
  other.init();
  {
    CrclProbe probe(target);
    probe.send(document);
    expect(probe.closed(kClosing), "the connection stays open");
  }
  const SeenStatus seen = other.poll();
  expect(seen.status.command.state == crcl::CommandState::kError,
         "elsewhere " + in_words(seen.status));
  expect(!seen.status.command.description.value_or("").empty(), "an error without a description");
  other.init();
  return "closed; elsewhere " + in_words(seen.status);
}

std::string root(const Target& target) {
  CrclProbe probe(target);
  const std::string document = probe.poll().document;
  std::string_view text = document;
  if (text.starts_with("<?xml")) text.remove_prefix(text.find("?>") + 2);
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  constexpr std::string_view kStart = "<CRCLStatus", kEnd = "</CRCLStatus>";
  const auto after = text.substr(0, kStart.size() + 1);
  expect(text.starts_with(kStart) && (after.back() == '>' || after.back() == ' '),
         "it begins with " + std::string(after));
  expect(text.ends_with(kEnd) && text.find("</CRCLStatus") == text.size() - kEnd.size(),
         "the end tag of the root stands elsewhere, too");
  return std::string(after.substr(0, kStart.size())) + " ... " + std::string(kEnd);
}

}  // namespace

void add(std::vector<Check>& checks) {
  const auto rule = [&checks](const char* clause, const char* source, const char* text,
                              const char* expected, auto run) {
    checks.push_back({clause, source, text, expected, false, run});
  };
  const std::string poll = get_status_document();
  rule("F1", kClients, "three documents in one packet", "3 statuses",
       [poll](const Target& t) { return answered(t, poll + poll + poll, 3); });
  rule("F2", kClients, "a document in packets of one byte", "1 status", bytewise);
  rule("F3", kClients, "half a document, the rest later", "1 status, after the rest", half);
  rule(
      "F4", kClients, "line ends and blanks between documents", "2 statuses",
      [poll](const Target& t) { return answered(t, "\r\n  " + poll + "\n\n\t" + poll + "\n", 2); });
  rule("F5", kClients, "a zero byte after a document, as old clients send it", "2 statuses",
       [poll](const Target& t) {
         return answered(t, poll + std::string(1, '\0') + poll + std::string(1, '\0'), 2);
       });
  rule("F6", kXml, "an XML declaration and a comment before the root", "1 status",
       [poll](const Target& t) {
         return answered(
             t, "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?><!-- c -->" + poll,
             1);
       });
  rule("F7", kXml, "a character of two bytes in two packets", "CRCL_Done", split_character);
  rule("F8", "XML Schema Part 1, 2.6", "xsi:type under another prefix, and a hint to a schema",
       "CRCL_Done", [](const Target& t) {
         const std::int64_t id = CrclProbe::next_id();
         return done(t, id,
                     fmt::format("<CRCLCommandInstance xmlns:q=\"http://www.w3.org/2001/"
                                 "XMLSchema-instance\" q:noNamespaceSchemaLocation=\"none/x.xsd\">"
                                 "<CRCLCommand q:type=\"MessageType\"><CommandID>{}</CommandID>"
                                 "<Message>hello</Message></CRCLCommand></CRCLCommandInstance>",
                                 id));
       });
  rule("F9", kXml, "a CDATA section and references in text", "CRCL_Done", [](const Target& t) {
    const std::int64_t id = CrclProbe::next_id();
    return done(
        t, id,
        command_document("MessageType", id, "<Message><![CDATA[a<b]]>&amp;&#228;</Message>"));
  });
  rule("F10", kClients, "a document that is not XML", "closed; an error that shows elsewhere",
       [](const Target& t) {
         return closes(t, "<CRCLCommandInstance><CRCLCommand></CRCLCommandInstance>");
       });
  rule("F11", kClients, "a command of an unknown type", "closed, or an error under its id",
       [](const Target& t) {
         const std::int64_t id = CrclProbe::next_id();
         return refused(t, command_document("FlyAwayType", id), id);
       });
  rule("F12", "XML 1.0, 2.8; security of servers", "a document type declaration", "closed",
       [poll](const Target& t) {
         return closes(t, "<!DOCTYPE CRCLCommandInstance [<!ENTITY a \"a\">]>" + poll);
       });
  rule("F13", kClients, "the root of a status", "no prefix, one end tag", root);
}

}  // namespace aprsim::client::conform::documents
