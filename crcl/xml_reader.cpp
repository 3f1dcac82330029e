#include "crcl/xml_reader.hpp"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <utility>

#include <xercesc/framework/MemBufInputSource.hpp>
#include <xercesc/sax2/Attributes.hpp>
#include <xercesc/sax2/DefaultHandler.hpp>
#include <xercesc/sax2/SAX2XMLReader.hpp>
#include <xercesc/sax2/XMLReaderFactory.hpp>
#include <xercesc/util/OutOfMemoryException.hpp>
#include <xercesc/util/PlatformUtils.hpp>
#include <xercesc/util/SecurityManager.hpp>
#include <xercesc/util/XMLException.hpp>
#include <xercesc/util/XMLUni.hpp>

#include "crcl/refused.hpp"
#include "crcl/text.hpp"

namespace aprsim::crcl {
namespace {

namespace xc = xercesc;

constexpr std::u16string_view kXsiNamespace = u"http://www.w3.org/2001/XMLSchema-instance";
constexpr std::u16string_view kTypeName = u"type";

static_assert(sizeof(XMLCh) == sizeof(char16_t));

void append_utf8(std::string& out, std::uint32_t c) {
  const auto put = [&out](std::uint32_t byte) { out += static_cast<char>(byte); };
  if (c < 0x80) {
    put(c);
  } else if (c < 0x800) {
    put(0xC0 | (c >> 6));
    put(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    put(0xE0 | (c >> 12));
    put(0x80 | ((c >> 6) & 0x3F));
    put(0x80 | (c & 0x3F));
  } else {
    put(0xF0 | (c >> 18));
    put(0x80 | ((c >> 12) & 0x3F));
    put(0x80 | ((c >> 6) & 0x3F));
    put(0x80 | (c & 0x3F));
  }
}

// Reports a surrogate pair that is split over two calls as two replacement characters; Xerces
// never splits one.
void append_utf16(std::string& out, const XMLCh* text, std::size_t length) {
  for (std::size_t i = 0; i < length; ++i) {
    std::uint32_t c = text[i];
    const bool high = c >= 0xD800 && c < 0xDC00;
    const bool low = c >= 0xDC00 && c < 0xE000;
    if (high && i + 1 < length && text[i + 1] >= 0xDC00 && text[i + 1] < 0xE000) {
      c = 0x10000 + ((c - 0xD800) << 10) + (text[++i] - 0xDC00U);
    } else if (high || low) {
      c = 0xFFFD;
    }
    append_utf8(out, c);
  }
}

std::string to_utf8(const XMLCh* text) {
  std::string out;
  if (text != nullptr) append_utf16(out, text, xc::XMLString::stringLen(text));
  return out;
}

bool equals(const XMLCh* text, std::u16string_view expected) {
  std::size_t i = 0;
  for (; text[i] != 0; ++i) {
    if (i >= expected.size() || text[i] != expected[i]) return false;
  }
  return i == expected.size();
}

class TreeBuilder final : public xc::DefaultHandler {
 public:
  explicit TreeBuilder(const XmlLimits& limits) : limits_(limits) {}

  XmlNode root() && { return std::move(root_); }

  void startElement(const XMLCh* uri, const XMLCh* local_name, const XMLCh* /*qualified*/,
                    const xc::Attributes& attributes) override {
    if (open_.size() >= limits_.max_depth) {
      throw Refused{"elements nested deeper than " + std::to_string(limits_.max_depth)};
    }
    if (attributes.getLength() > limits_.max_attributes) {
      throw Refused{"more than " + std::to_string(limits_.max_attributes) + " attributes"};
    }
    std::string name = to_utf8(local_name);
    if (uri[0] != 0) throw Refused{"element " + shorten(name) + " in a namespace, expected none"};
    XmlNode* node = &root_;
    // Addresses of open elements stay good: a sibling is only added once this one is closed.
    if (!open_.empty()) node = &open_.back()->children.emplace_back();
    node->name = std::move(name);
    node->type = type_of(attributes);
    open_.push_back(node);
  }

  void endElement(const XMLCh* /*uri*/, const XMLCh* /*local_name*/,
                  const XMLCh* /*qualified*/) override {
    open_.pop_back();
  }

  void characters(const XMLCh* text, XMLSize_t length) override {
    append_utf16(open_.back()->text, text, length);
  }

  void startDTD(const XMLCh*, const XMLCh*, const XMLCh*) override {
    throw Refused{"document type declarations are not accepted"};
  }

  xc::InputSource* resolveEntity(const XMLCh*, const XMLCh*) override {
    throw Refused{"external entities are not accepted"};
  }

  void error(const xc::SAXParseException& problem) override { fatalError(problem); }

  void fatalError(const xc::SAXParseException& problem) override {
    throw Refused{"line " + std::to_string(problem.getLineNumber()) + ", column " +
                  std::to_string(problem.getColumnNumber()) + ": " + to_utf8(problem.getMessage())};
  }

 private:
  static std::string type_of(const xc::Attributes& attributes) {
    for (XMLSize_t i = 0; i < attributes.getLength(); ++i) {
      if (!equals(attributes.getURI(i), kXsiNamespace)) continue;
      if (!equals(attributes.getLocalName(i), kTypeName)) continue;
      const std::string value = to_utf8(attributes.getValue(i));
      const std::string_view name = trim(value);
      const std::size_t colon = name.rfind(':');
      return std::string(colon == std::string_view::npos ? name : name.substr(colon + 1));
    }
    return {};
  }

  const XmlLimits& limits_;
  XmlNode root_;
  std::vector<XmlNode*> open_;
};

// One parser with every feature off that reads anything but the bytes at hand.
class Parser {
 public:
  Parser() {
    initialize_xml();
    reader_.reset(xc::XMLReaderFactory::createXMLReader());
    security_.setEntityExpansionLimit(kMaxEntityExpansions);
    reader_->setProperty(xc::XMLUni::fgXercesSecurityManager, &security_);
    reader_->setFeature(xc::XMLUni::fgSAX2CoreNameSpaces, true);
    reader_->setFeature(xc::XMLUni::fgSAX2CoreValidation, false);
    reader_->setFeature(xc::XMLUni::fgXercesDynamic, false);
    reader_->setFeature(xc::XMLUni::fgXercesSchema, false);
    reader_->setFeature(xc::XMLUni::fgXercesLoadSchema, false);
    reader_->setFeature(xc::XMLUni::fgXercesLoadExternalDTD, false);
    reader_->setFeature(xc::XMLUni::fgXercesSkipDTDValidation, true);
    reader_->setFeature(xc::XMLUni::fgXercesDisableDefaultEntityResolution, true);
    reader_->setFeature(xc::XMLUni::fgXercesCacheGrammarFromParse, false);
  }

  XmlNode parse(std::string_view document, const XmlLimits& limits) {
    TreeBuilder builder(limits);
    reader_->setContentHandler(&builder);
    reader_->setErrorHandler(&builder);
    reader_->setEntityResolver(&builder);
    reader_->setLexicalHandler(&builder);
    const auto* bytes = reinterpret_cast<const XMLByte*>(document.data());
    xc::MemBufInputSource source(bytes, document.size(), "CRCL", false);
    source.setCopyBufToStream(false);
    reader_->parse(source);
    return std::move(builder).root();
  }

 private:
  xc::SecurityManager security_;
  std::unique_ptr<xc::SAX2XMLReader> reader_;
};

tl::unexpected<Error> malformed(std::string what) {
  Error error;
  error.kind = ErrorKind::kMalformed;
  error.element = "XML";
  error.expected = std::move(what);
  return tl::unexpected<Error>(std::move(error));
}

// Xerces refuses a DOCTYPE with the same words as bytes that are no XML at all.
std::string reason(const Refused& refused, std::string_view document) {
  const bool structure = refused.what.ends_with("invalid document structure");
  if (!structure || document.find("<!DOCTYPE") == std::string_view::npos) return refused.what;
  return "document type declarations are not accepted";
}

const XmlNode& empty_node() {
  static const XmlNode node;
  return node;
}

constexpr const char* kNumber = "expected a finite number";
constexpr const char* kInteger = "expected an integer";
constexpr const char* kMissing = "missing";

}  // namespace

const XmlNode* XmlNode::child(std::string_view child_name) const {
  for (const XmlNode& node : children) {
    if (node.name == child_name) return &node;
  }
  return nullptr;
}

void initialize_xml() {
  static std::once_flag once;
  std::call_once(once, [] {
    // Debian's 3.2.4 leaks for every document with an external DTD (its answer to CVE-2018-1311);
    // with this set it refuses any DOCTYPE before that.
    ::setenv("XERCES_DISABLE_DTD", "1", 1);
    xc::XMLPlatformUtils::Initialize();
  });
}

Result<XmlNode> parse_xml(std::string_view document, const XmlLimits& limits) {
  if (document.size() > limits.max_bytes) {
    return malformed("expected at most " + std::to_string(limits.max_bytes) + " bytes, got " +
                     std::to_string(document.size()));
  }
  // A parser keeps every namespace that it has seen, so it serves for a while only.
  constexpr int kDocumentsPerParser = 64;
  thread_local std::unique_ptr<Parser> parser;
  thread_local int left = 0;
  if (left-- <= 0) {
    parser = std::make_unique<Parser>();
    left = kDocumentsPerParser - 1;
  }
  try {
    return parser->parse(document, limits);
  } catch (const Refused& refused) {
    return malformed(reason(refused, document));
  } catch (const xc::OutOfMemoryException&) {
    throw std::bad_alloc();
  } catch (const xc::XMLException& problem) {
    return malformed(to_utf8(problem.getMessage()));
  } catch (const xc::SAXException& problem) {
    return malformed(to_utf8(problem.getMessage()));
  }
}

Fields Fields::child(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) {
    fail(name, "", kMissing);
    return {empty_node(), *slot_, this};
  }
  return {*found, *slot_, this};
}

std::vector<Fields> Fields::children(std::string_view name) const {
  std::vector<Fields> found;
  for (const XmlNode& node : node_->children) {
    if (node.name == name) found.push_back(Fields(node, *slot_, this));
  }
  return found;
}

std::optional<double> Fields::optional_number(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) return std::nullopt;
  const std::optional<double> value = parse_double(found->text);
  if (value && std::isfinite(*value)) return value;
  fail(name, found->text, kNumber);
  return std::nullopt;
}

double Fields::number(std::string_view name) const {
  if (!has(name)) fail(name, "", kMissing);
  return optional_number(name).value_or(0);
}

std::optional<int> Fields::optional_integer(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) return std::nullopt;
  const std::optional<int> value = parse_int(found->text);
  if (!value) fail(name, found->text, kInteger);
  return value;
}

int Fields::integer(std::string_view name) const {
  if (!has(name)) fail(name, "", kMissing);
  return optional_integer(name).value_or(0);
}

std::optional<std::int64_t> Fields::optional_long(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) return std::nullopt;
  const std::optional<std::int64_t> value = parse_long(found->text);
  if (!value) fail(name, found->text, kInteger);
  return value;
}

std::optional<bool> Fields::optional_flag(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) return std::nullopt;
  const std::optional<bool> value = parse_bool(found->text);
  if (!value) fail(name, found->text, "expected true or false");
  return value;
}

bool Fields::flag(std::string_view name) const { return optional_flag(name).value_or(false); }

std::optional<std::string> Fields::optional_text(std::string_view name) const {
  const XmlNode* found = node_->child(name);
  if (found == nullptr) return std::nullopt;
  return found->text;
}

std::string Fields::text(std::string_view name) const {
  if (!has(name)) fail(name, "", kMissing);
  return optional_text(name).value_or("");
}

void Fields::fail(std::string_view name, std::string_view value, std::string expected,
                  ErrorKind kind) const {
  if (slot_->has_value()) return;
  Error error;
  error.kind = kind;
  error.element = path();
  if (!name.empty()) error.element += "/" + std::string(name);
  error.value = shorten(trim(value));
  error.expected = std::move(expected);
  *slot_ = std::move(error);
}

std::string Fields::path() const {
  if (parent_ == nullptr) return node_->type.empty() ? node_->name : node_->type;
  return parent_->path() + "/" + node_->name;
}

}  // namespace aprsim::crcl
