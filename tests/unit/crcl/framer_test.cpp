#include "crcl/framer.hpp"

#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

namespace aprsim::crcl {
namespace {

const std::string kA = "<CRCLCommandInstance><x>\xC3\xA4</x></CRCLCommandInstance>";
const std::string kB =
    "<?xml version=\"1.0\"?><!-- hi -->\n<CRCLCommandInstance>\n</CRCLCommandInstance\n>";

std::vector<std::string> drain(Framer& framer) {
  std::vector<std::string> documents;
  while (true) {
    Result<std::optional<std::string>> next = framer.next();
    EXPECT_TRUE(next) << next.error().message();
    if (!next || !*next) return documents;
    documents.push_back(std::move(**next));
  }
}

TEST(Framer, CutsSeveralDocumentsOutOfOneRead) {
  Framer framer = Framer::for_commands();
  framer.append(kA + kB + "\r\n" + kA + "<CRCLComm");
  EXPECT_EQ(drain(framer), (std::vector<std::string>{kA, kB, kA}));
  EXPECT_EQ(framer.buffered(), 9U);
}

TEST(Framer, DropsNulAndSpaceBetweenDocuments) {
  Framer framer = Framer::for_commands();
  const std::string separators("\0 \r\n\t\0\0", 7);
  framer.append(separators + kA + separators + kA + separators);
  EXPECT_EQ(drain(framer), (std::vector<std::string>{kA, kA}));
  EXPECT_EQ(framer.buffered(), 0U);
}

TEST(Framer, DoesNotMistakeALongerTag) {
  Framer framer = Framer::for_commands();
  const std::string longer = "<CRCLCommandInstance></CRCLCommandInstanceX></CRCLCommandInstance>";
  framer.append(longer);
  EXPECT_EQ(drain(framer), std::vector<std::string>{longer});
}

TEST(Framer, AnySplitGivesTheSameDocuments) {
  const std::string stream =
      std::string("\0\n", 2) + kA + kB + std::string(1, '\0') + kA + kB + "\n";
  const std::vector<std::string> expected{kA, kB, kA, kB};
  EXPECT_TRUE(rc::check("framing does not depend on packets", [&] {
    Framer framer = Framer::for_commands();
    std::vector<std::string> documents;
    std::size_t at = 0;
    while (at < stream.size()) {
      const auto size = *rc::gen::inRange<std::size_t>(1, 40);
      framer.append(std::string_view(stream).substr(at, size));
      at += size;
      for (std::string& document : drain(framer)) documents.push_back(std::move(document));
    }
    RC_ASSERT(documents == expected);
  }));
}

TEST(Framer, AnySplitOfAnyPiecesGivesTheSameDocuments) {
  EXPECT_TRUE(rc::check("framing of rubbish does not depend on packets either", [] {
    const auto pieces = *rc::gen::container<std::vector<std::string>>(rc::gen::element<std::string>(
        "<CRCLProgram>", "</CRCLProgram>", "<CRCLCommandInstance>", "</CRCLCommandInstance>",
        "</CRCLCommandInstance >", "<CRCLProg", "</CRCL", "x", "<!-- ", "\n",
        std::string(1, '\0')));
    std::string stream;
    for (const std::string& piece : pieces) stream += piece;
    Framer whole = Framer::for_commands(100'000, 200'000);
    whole.append(stream);
    const std::vector<std::string> expected = drain(whole);
    Framer framer = Framer::for_commands(100'000, 200'000);
    std::vector<std::string> documents;
    std::size_t at = 0;
    while (at < stream.size()) {
      const auto size = *rc::gen::inRange<std::size_t>(1, 30);
      framer.append(std::string_view(stream).substr(at, size));
      at += size;
      for (std::string& document : drain(framer)) documents.push_back(std::move(document));
    }
    RC_ASSERT(documents == expected);
  }));
}

TEST(Framer, ProgramsAndCommandsMayAlternate) {
  const std::string program =
      "<?xml?><CRCLProgram><MiddleCommand>&lt;/CRCLCommandInstance&gt;</MiddleCommand></"
      "CRCLProgram>";
  const std::string carrier =
      "<CRCLCommandInstance><![CDATA[<CRCLProgram></CRCLProgram>]]></CRCLCommandInstance>";
  Framer framer = Framer::for_commands(100, 1000);
  framer.append(kA + program + "\n" + carrier + kB);
  std::vector<std::size_t> roots;
  std::vector<std::string> documents;
  for (auto next = framer.next(); next && *next; next = framer.next()) {
    documents.push_back(**next);
    roots.push_back(framer.last_root());
  }
  EXPECT_EQ(documents, (std::vector<std::string>{kA, program, carrier, kB}));
  EXPECT_EQ(roots, (std::vector<std::size_t>{0, 1, 0, 0}));
}

TEST(Framer, ProgramsHaveALimitOfTheirOwn) {
  Framer framer = Framer::for_commands(100, 300);
  framer.append("<CRCLProgram>" + std::string(250, 'x'));
  EXPECT_TRUE(framer.next());
  framer.append(std::string(60, 'x'));
  EXPECT_FALSE(framer.next());
  Framer commands_only = Framer::for_commands(100);
  commands_only.append("<CRCLProgram>" + std::string(250, 'x'));
  EXPECT_FALSE(commands_only.next());
}

TEST(Framer, ByteByByte) {
  Framer framer = Framer::for_commands();
  std::vector<std::string> documents;
  for (const char c : kA + kB) {
    framer.append({&c, 1});
    for (std::string& document : drain(framer)) documents.push_back(std::move(document));
  }
  EXPECT_EQ(documents, (std::vector<std::string>{kA, kB}));
}

TEST(Framer, TagsInCommentsAndDataAreText) {
  const std::string commented =
      "<!-- <CRCLProgram></CRCLProgram></CRCLCommandInstance> --><CRCLCommandInstance>"
      "<!-- </CRCLCommandInstance> <![CDATA[ --><![CDATA[</CRCLCommandInstance><!-- ]]>"
      "</CRCLCommandInstance>";
  for (const std::size_t size : {commented.size(), std::size_t{1}, std::size_t{7}}) {
    Framer framer = Framer::for_commands(1000, 1000);
    std::vector<std::string> documents;
    const std::string stream = commented + kA;
    for (std::size_t at = 0; at < stream.size(); at += size) {
      framer.append(std::string_view(stream).substr(at, size));
      for (std::string& document : drain(framer)) documents.push_back(std::move(document));
    }
    EXPECT_EQ(documents, (std::vector<std::string>{commented, kA})) << size << " bytes at a time";
    EXPECT_EQ(framer.last_root(), 0U);
  }
}

TEST(Framer, RefusesWideEncodings) {
  const std::string text = "<?xml version=\"1.0\" encoding=\"UTF-16\"?><CRCLCommandInstance/>";
  std::string little, big;
  for (const char c : text) {
    little += {c, '\0'};
    big += {'\0', c};
  }
  for (const std::string& stream : {little, big, "\xFF\xFE" + little, "\xFE\xFF" + big}) {
    Framer framer = Framer::for_commands();
    framer.append(kA + "\n" + stream);
    EXPECT_EQ(framer.next().value(), kA);
    const Result<std::optional<std::string>> next = framer.next();
    ASSERT_FALSE(next);
    EXPECT_EQ(next.error().kind, ErrorKind::kMalformed);
    EXPECT_EQ(
        next.error().message(),
        "the document is in UTF-16 or UTF-32, expected UTF-8 or another encoding of single bytes");
  }
}

TEST(Framer, RefusesADocumentThatGrowsTooLarge) {
  Framer framer = Framer::for_commands(100);
  framer.append("<CRCLCommandInstance>" + std::string(79, 'x'));
  EXPECT_TRUE(framer.next());
  framer.append("y");
  const Result<std::optional<std::string>> next = framer.next();
  ASSERT_FALSE(next);
  EXPECT_EQ(next.error().kind, ErrorKind::kTooLarge);
  EXPECT_NE(next.error().message().find("100 bytes"), std::string::npos);
}

TEST(Framer, RefusesACompleteDocumentThatIsTooLarge) {
  Framer framer = Framer::for_commands(100);
  framer.append("<CRCLCommandInstance>" + std::string(100, 'x') + "</CRCLCommandInstance>");
  EXPECT_FALSE(framer.next());
}

TEST(Framer, ManySmallDocumentsExceedNoLimit) {
  Framer framer = Framer::for_commands(100);
  std::string stream;
  for (int i = 0; i < 1000; ++i) stream += kA;
  framer.append(stream);
  EXPECT_EQ(drain(framer).size(), 1000U);
}

TEST(Framer, SeparatorsNeverFillTheBuffer) {
  Framer framer = Framer::for_commands(100);
  for (int i = 0; i < 100; ++i) {
    framer.append(std::string(100, '\0'));
    ASSERT_TRUE(framer.next());
  }
  EXPECT_EQ(framer.buffered(), 0U);
}

TEST(Framer, FindsStatusesForAClient) {
  Framer framer = Framer::for_statuses();
  framer.append("<?xml?><CRCLStatus>1</CRCLStatus><?xml?><CRCLStatus>2</CRCLStatus>");
  EXPECT_EQ(drain(framer).size(), 2U);
}

TEST(Framer, AnEndTagMayGoOnWithBlanksInPieces) {
  Framer framer = Framer::for_commands();
  const std::string head = "<CRCLCommandInstance></CRCLCommandInstance";
  for (const char* last : {">", "x></CRCLCommandInstance >"}) {
    framer.append(head);
    for (int i = 0; i < 5000; ++i) {
      EXPECT_EQ(framer.next().value(), std::nullopt);
      framer.append(i % 2 == 0 ? " " : "\n\t");
    }
    framer.append(last);
    const auto document = framer.next();
    ASSERT_TRUE(document && *document);
    EXPECT_TRUE((*document)->starts_with(head + " \n\t"));
    EXPECT_TRUE((*document)->ends_with(last));
    EXPECT_EQ(framer.buffered(), 0U);
  }
  framer.append(head + ">" + head + " ");
  EXPECT_EQ(framer.next().value(), head + ">");
  EXPECT_EQ(framer.next().value(), std::nullopt);
  framer.append(">");
  EXPECT_EQ(framer.next().value(), head + " >");
}

}  // namespace
}  // namespace aprsim::crcl
