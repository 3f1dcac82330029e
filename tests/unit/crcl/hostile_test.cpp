#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "crcl/command_codec.hpp"
#include "tests/unit/crcl/samples.hpp"

namespace aprsim::crcl {
namespace {

Error expect_refused(const std::string& document) {
  const Result<CommandInstance> instance = decode_command(document);
  EXPECT_FALSE(instance) << document.substr(0, 100);
  return instance ? Error{} : instance.error();
}

const std::string kInit = with_id("InitCanonType", "");

TEST(Hostile, AnyDoctypeIsRefused) {
  for (const char* doctype :
       {"<!DOCTYPE CRCLCommandInstance>",
        "<!DOCTYPE CRCLCommandInstance SYSTEM 'file:///etc/passwd'>",
        "<!DOCTYPE CRCLCommandInstance [<!ENTITY a 'b'>]>",
        "<!DOCTYPE CRCLCommandInstance [<!ENTITY a SYSTEM 'file:///etc/hostname'>]>"}) {
    const Error error = expect_refused(doctype + kInit);
    EXPECT_EQ(error.kind, ErrorKind::kMalformed) << doctype;
    EXPECT_EQ(error.message(), "XML: document type declarations are not accepted") << doctype;
  }
}

TEST(Hostile, EntityBombsDoNotGoOff) {
  std::string bomb = "<!DOCTYPE CRCLCommandInstance [<!ENTITY e0 'xxxxxxxxxx'>";
  for (int i = 1; i < 10; ++i) {
    std::string ten;
    for (int k = 0; k < 10; ++k) ten += "&e" + std::to_string(i - 1) + ";";
    bomb += "<!ENTITY e" + std::to_string(i) + " '" + ten + "'>";
  }
  bomb += "]>" + with_id("MessageType", "<Message>&e9;</Message>");
  EXPECT_EQ(expect_refused(bomb).message(), "XML: document type declarations are not accepted");
}

TEST(Hostile, UndeclaredEntitiesAreRefused) {
  expect_refused(with_id("MessageType", "<Message>&secret;</Message>"));
}

std::string nested(int levels) {
  std::string body;
  for (int i = 0; i < levels; ++i) body += "<a>";
  for (int i = 0; i < levels; ++i) body += "</a>";
  return with_id("InitCanonType", body);
}

TEST(Hostile, DepthIsLimited) {
  EXPECT_TRUE(decode_command(nested(30)));
  EXPECT_NE(expect_refused(nested(31)).message().find("deeper than 32"), std::string::npos);
  EXPECT_EQ(expect_refused(nested(9000)).kind, ErrorKind::kMalformed);
}

TEST(Hostile, AttributesAreLimited) {
  std::string attributes;
  for (int i = 0; i < 65; ++i) attributes += " a" + std::to_string(i) + "='1'";
  expect_refused("<CRCLCommandInstance" + attributes + "></CRCLCommandInstance>");
}

TEST(Hostile, SizeIsLimited) {
  const std::string filler(kMaxCommandBytes, 'x');
  EXPECT_NE(expect_refused(with_id("MessageType", "<Message>" + filler + "</Message>"))
                .message()
                .find("at most 65536 bytes"),
            std::string::npos);
}

TEST(Hostile, NamespacedElementsAreRefused) {
  expect_refused("<CRCLCommandInstance xmlns='urn:x'></CRCLCommandInstance>");
}

TEST(Hostile, BrokenXmlSaysWhere) {
  EXPECT_EQ(expect_refused("<CRCLCommandInstance>\n<a></b></CRCLCommandInstance>")
                .message()
                .substr(0, 11),
            "XML: line 2");
}

TEST(Hostile, BytesThatAreNotUtf8AreRefused) {
  expect_refused(with_id("MessageType", "<Message>\xC3\x28</Message>"));
  expect_refused(with_id("MessageType", std::string("<Message>\0</Message>", 20)));
}

TEST(Hostile, TheParserIsGoodForTheNextDocument) {
  for (int i = 0; i < 50; ++i) {
    expect_refused("<!DOCTYPE a>" + kInit);
    expect_refused(nested(40));
    expect_refused("<CRCLCommandInstance><a></CRCLCommandInstance>");
    EXPECT_TRUE(decode_command(kInit));
  }
}

TEST(Hostile, AnyDamageEitherDecodesOrIsAnError) {
  const std::string whole = with_id("MoveToType", "<MoveStraight>true</MoveStraight><EndPosition>" +
                                                      pose_xml() + "</EndPosition>");
  EXPECT_TRUE(rc::check("no damage makes the decoder fail otherwise", [&] {
    std::string document = whole;
    const int edits = *rc::gen::inRange(1, 6);
    for (int i = 0; i < edits; ++i) {
      const auto at = *rc::gen::inRange<std::size_t>(0, document.size());
      switch (*rc::gen::inRange(0, 3)) {
        case 0:
          document[at] = *rc::gen::arbitrary<char>();
          break;
        case 1:
          document.erase(at, 5);
          break;
        default:
          document.insert(at, document.substr(at / 2, 9));
          break;
      }
    }
    const Result<CommandInstance> instance = decode_command(document);
    const bool decoded = instance.has_value();
    if (!decoded) RC_ASSERT(!instance.error().message().empty());
  }));
}

}  // namespace
}  // namespace aprsim::crcl
