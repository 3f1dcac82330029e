#include "crcl/schema.hpp"

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include <xercesc/framework/MemBufInputSource.hpp>
#include <xercesc/framework/XMLGrammarPoolImpl.hpp>
#include <xercesc/sax/SAXParseException.hpp>
#include <xercesc/sax2/DefaultHandler.hpp>
#include <xercesc/sax2/SAX2XMLReader.hpp>
#include <xercesc/sax2/XMLReaderFactory.hpp>
#include <xercesc/util/SecurityManager.hpp>
#include <xercesc/util/XMLException.hpp>
#include <xercesc/util/XMLString.hpp>
#include <xercesc/util/XMLUni.hpp>
#include <xercesc/validators/common/Grammar.hpp>

#include "crcl/refused.hpp"
#include "crcl/text.hpp"
#include "crcl/xml_reader.hpp"

namespace aprsim::crcl {
namespace {

namespace xc = xercesc;

std::string to_text(const XMLCh* text) {
  if (text == nullptr) return {};
  const std::unique_ptr<char, void (*)(char*)> copy(
      xc::XMLString::transcode(text), [](char* owned) { xc::XMLString::release(&owned); });
  return copy.get();
}

std::unique_ptr<xc::MemBufInputSource> source_of(std::string_view text, const std::string& id) {
  const auto* bytes = reinterpret_cast<const XMLByte*>(text.data());
  auto source = std::make_unique<xc::MemBufInputSource>(bytes, text.size(), id.c_str(), false);
  source->setCopyBufToStream(false);
  return source;
}

// Ends a parse at the first fault. Resolves only the schemas here.
class Handler final : public xc::DefaultHandler {
 public:
  void error(const xc::SAXParseException& problem) override { fatalError(problem); }
  void fatalError(const xc::SAXParseException& problem) override {
    throw Refused{"line " + std::to_string(problem.getLineNumber()) + ", column " +
                  std::to_string(problem.getColumnNumber()) + ": " +
                  shorten(to_text(problem.getMessage()), 400)};
  }
  void startDTD(const XMLCh*, const XMLCh*, const XMLCh*) override {
    throw Refused{"document type declarations are not accepted"};
  }
  xc::InputSource* resolveEntity(const XMLCh*, const XMLCh* system_id) override {
    const std::string id = to_text(system_id);
    for (const SchemaFile& file : schema_files()) {
      if (id == file.name) return source_of(file.text, id).release();
    }
    throw Refused{"external entities are not accepted"};
  }
};

class Validator {
 public:
  Validator() {
    reader_.reset(
        xc::XMLReaderFactory::createXMLReader(xc::XMLPlatformUtils::fgMemoryManager, &grammars_));
    security_.setEntityExpansionLimit(kMaxEntityExpansions);
    reader_->setProperty(xc::XMLUni::fgXercesSecurityManager, &security_);
    reader_->setFeature(xc::XMLUni::fgSAX2CoreNameSpaces, true);
    reader_->setFeature(xc::XMLUni::fgSAX2CoreValidation, true);
    reader_->setFeature(xc::XMLUni::fgXercesDynamic, false);
    reader_->setFeature(xc::XMLUni::fgXercesSchema, true);
    reader_->setFeature(xc::XMLUni::fgXercesSchemaFullChecking, false);
    reader_->setFeature(xc::XMLUni::fgXercesLoadExternalDTD, false);
    reader_->setFeature(xc::XMLUni::fgXercesDisableDefaultEntityResolution, true);
    reader_->setErrorHandler(&handler_);
    reader_->setEntityResolver(&handler_);
    reader_->setLexicalHandler(&handler_);
    load();
    reader_->setFeature(xc::XMLUni::fgXercesUseCachedGrammarInParse, true);
    reader_->setFeature(xc::XMLUni::fgXercesCacheGrammarFromParse, false);
    reader_->setFeature(xc::XMLUni::fgXercesLoadSchema, false);
  }

  std::optional<std::string> fault(std::string_view document) {
    try {
      reader_->parse(*source_of(document, "CRCL"));
      return std::nullopt;
    } catch (const Refused& refused) {
      return refused.what;
    } catch (const xc::XMLException& problem) {
      return to_text(problem.getMessage());
    } catch (const xc::SAXException& problem) {
      return to_text(problem.getMessage());
    }
  }

 private:
  // A pool holds one grammar without a namespace, so one file that includes all others.
  void load() {
    std::string all = R"(<schema xmlns="http://www.w3.org/2001/XMLSchema">)";
    for (const SchemaFile& file : schema_files()) {
      all += "<include schemaLocation=\"" + std::string(file.name) + "\"/>";
    }
    all += "</schema>";
    try {
      const auto source = source_of(all, "all.xsd");
      if (reader_->loadGrammar(*source, xc::Grammar::SchemaGrammarType, true) != nullptr) return;
    } catch (const Refused& refused) {
      throw std::logic_error("the built-in schemas are wrong: " + refused.what);
    }
    throw std::logic_error("the built-in schemas cannot be loaded");
  }

  // Members allocate by the library, which therefore is initialised before all of them.
  struct Library {
    Library() { initialize_xml(); }
  } library_;
  Handler handler_;
  xc::SecurityManager security_;
  xc::XMLGrammarPoolImpl grammars_;
  std::unique_ptr<xc::SAX2XMLReader> reader_;
};

}  // namespace

std::optional<Error> schema_fault(std::string_view document) {
  thread_local Validator validator;
  std::optional<std::string> fault = validator.fault(document);
  if (!fault) return std::nullopt;
  Error error;
  error.kind = ErrorKind::kMalformed;
  error.element = "Schema";
  error.expected = std::move(*fault);
  return error;
}

}  // namespace aprsim::crcl
