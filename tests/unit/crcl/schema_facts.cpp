#include "tests/unit/crcl/schema_facts.hpp"

#include <xercesc/dom/DOM.hpp>
#include <xercesc/framework/MemBufInputSource.hpp>
#include <xercesc/parsers/XercesDOMParser.hpp>
#include <xercesc/util/XMLString.hpp>

#include "crcl/xml_reader.hpp"

namespace aprsim::crcl {
namespace {

namespace xc = xercesc;

std::string text_of(const XMLCh* text) {
  char* copy = xc::XMLString::transcode(text);
  std::string out = copy;
  xc::XMLString::release(&copy);
  return out;
}

std::string attribute(const xc::DOMElement& element, const char* name,
                      const std::string& fallback = "") {
  XMLCh* key = xc::XMLString::transcode(name);
  const std::string value = text_of(element.getAttribute(key));
  xc::XMLString::release(&key);
  return value.empty() ? fallback : value;
}

// The elements inside a declaration in document order, in words.
void describe(const xc::DOMElement& element, std::string& out) {
  for (auto* child = element.getFirstElementChild(); child != nullptr;
       child = child->getNextElementSibling()) {
    const std::string kind = text_of(child->getLocalName());
    if (kind == "annotation") continue;
    if (kind == "extension") out += "extends " + attribute(*child, "base") + ":";
    if (kind == "restriction") out += "restricts " + attribute(*child, "base") + ":";
    if (kind == "element") {
      out += " " + attribute(*child, "name") + " " + attribute(*child, "type") + " " +
             attribute(*child, "minOccurs", "1") + ".." + attribute(*child, "maxOccurs", "1");
    }
    const std::string value = attribute(*child, "value");
    if (!value.empty()) out += " " + kind + "=" + value;
    describe(*child, out);
  }
}

}  // namespace

std::map<std::string, std::string> schema_facts(const std::vector<std::string>& documents) {
  initialize_xml();
  std::map<std::string, std::string> facts;
  for (const std::string& document : documents) {
    xc::XercesDOMParser parser;
    parser.setDoNamespaces(true);
    const auto* bytes = reinterpret_cast<const XMLByte*>(document.data());
    const xc::MemBufInputSource source(bytes, document.size(), "schema", false);
    parser.parse(source);
    const xc::DOMElement* root = parser.getDocument()->getDocumentElement();
    for (auto* declared = root->getFirstElementChild(); declared != nullptr;
         declared = declared->getNextElementSibling()) {
      const std::string name = attribute(*declared, "name");
      if (name.empty()) continue;
      std::string line;
      describe(*declared, line);
      if (attribute(*declared, "abstract") == "true") line += " abstract";
      line += attribute(*declared, "type");
      facts[text_of(declared->getLocalName()) + " " + name] = line;
    }
  }
  return facts;
}

}  // namespace aprsim::crcl
