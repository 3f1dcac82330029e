#include "tests/unit/crcl/schema_validator.hpp"

#include <stdexcept>

#include <xercesc/framework/MemBufInputSource.hpp>
#include <xercesc/framework/XMLGrammarPoolImpl.hpp>
#include <xercesc/sax/SAXParseException.hpp>
#include <xercesc/sax2/DefaultHandler.hpp>
#include <xercesc/sax2/SAX2XMLReader.hpp>
#include <xercesc/sax2/XMLReaderFactory.hpp>
#include <xercesc/util/PlatformUtils.hpp>
#include <xercesc/util/XMLString.hpp>
#include <xercesc/util/XMLUni.hpp>
#include <xercesc/validators/common/Grammar.hpp>

#include "crcl/xml_reader.hpp"

namespace aprsim::crcl {
namespace {

namespace xc = xercesc;

class FirstFault final : public xc::DefaultHandler {
 public:
  std::string text;
  void error(const xc::SAXParseException& problem) override { keep(problem); }
  void fatalError(const xc::SAXParseException& problem) override { keep(problem); }

 private:
  void keep(const xc::SAXParseException& problem) {
    if (!text.empty()) return;
    char* message = xc::XMLString::transcode(problem.getMessage());
    text = std::to_string(problem.getLineNumber()) + ":" +
           std::to_string(problem.getColumnNumber()) + ": " + message;
    xc::XMLString::release(&message);
  }
};

}  // namespace

struct SchemaValidator::Impl {
  std::unique_ptr<xc::SAX2XMLReader> reader;
};

SchemaValidator::SchemaValidator(const std::string& schema_file) : impl_(std::make_unique<Impl>()) {
  initialize_xml();
  impl_->reader.reset(xc::XMLReaderFactory::createXMLReader());
  xc::SAX2XMLReader& reader = *impl_->reader;
  reader.setFeature(xc::XMLUni::fgSAX2CoreNameSpaces, true);
  reader.setFeature(xc::XMLUni::fgSAX2CoreValidation, true);
  reader.setFeature(xc::XMLUni::fgXercesSchema, true);
  reader.setFeature(xc::XMLUni::fgXercesSchemaFullChecking, true);
  FirstFault faults;
  reader.setErrorHandler(&faults);
  if (reader.loadGrammar(schema_file.c_str(), xc::Grammar::SchemaGrammarType, true) == nullptr) {
    throw std::runtime_error("cannot load " + schema_file + ": " + faults.text);
  }
  reader.setFeature(xc::XMLUni::fgXercesUseCachedGrammarInParse, true);
  reader.setFeature(xc::XMLUni::fgXercesLoadSchema, false);
}

SchemaValidator::~SchemaValidator() = default;

std::string SchemaValidator::fault(const std::string& document) const {
  FirstFault faults;
  impl_->reader->setErrorHandler(&faults);
  const auto* bytes = reinterpret_cast<const XMLByte*>(document.data());
  const xc::MemBufInputSource source(bytes, document.size(), "document", false);
  impl_->reader->parse(source);
  return faults.text;
}

}  // namespace aprsim::crcl
