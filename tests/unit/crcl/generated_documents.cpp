#include "tests/unit/crcl/generated_documents.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "crcl/schema.hpp"
#include "crcl/text.hpp"
#include "tests/unit/crcl/schema_facts.hpp"

namespace aprsim::crcl {

GeneratedDocuments::GeneratedDocuments() {
  std::vector<std::string> schemas;
  for (const SchemaFile& file : schema_files()) schemas.emplace_back(file.text);
  // A line is "extends BASE: NAME TYPE LEAST..MOST ... abstract", or "restricts BASE: key=value
  // ...".
  for (const auto& [declared, facts] : schema_facts(schemas)) {
    std::istringstream kind(declared), line(facts);
    std::string what, name, word;
    kind >> what >> name;
    if (what == "simpleType") {
      while (line >> word) {
        if (word.starts_with("enumeration=")) words_[name].push_back(word.substr(12));
      }
    } else if (what == "complexType") {
      Type& type = types_[name];
      while (line >> word) {
        if (word == "extends") {
          line >> type.base;
          type.base.pop_back();
        } else if (word.find("abstract") != std::string::npos) {
          type.abstract = true;
        } else {
          Element element{word, "", 1, 1};
          std::string count;
          line >> element.type >> count;
          element.least = std::stoi(count);
          const std::string most = count.substr(count.find("..") + 2);
          element.most = most == "unbounded" ? element.least + 2 : std::stoi(most);
          type.elements.push_back(element);
        }
      }
    }
  }
  for (const auto& [name, type] : types_) {
    if (type.abstract) continue;
    for (std::string base = name; !base.empty(); base = types_.at(base).base) {
      types_.at(base).concrete.push_back(name);
    }
  }
}

std::string GeneratedDocuments::document(unsigned number) {
  random_.seed(number);
  static constexpr const char* kRoots[] = {"CRCLCommandInstance", "CRCLStatus", "CRCLProgram"};
  const std::string root = kRoots[number % 3];
  std::string out;
  write(root, root + "Type", out);
  return out;
}

int GeneratedDocuments::below(int end) {
  return std::uniform_int_distribution(0, end - 1)(random_);
}

void GeneratedDocuments::write(const std::string& name, const std::string& type, std::string& out) {
  const auto known = types_.find(type);
  if (known == types_.end()) {
    out += "<" + name + ">";
    write_value(type, out);
    out += "</" + name + ">";
    return;
  }
  const auto& concrete = known->second.concrete;
  const std::string& chosen =
      concrete.at(static_cast<std::size_t>(below(static_cast<int>(concrete.size()))));
  out += "<" + name;
  if (chosen != type) {
    out += " xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:type=\"" + chosen + "\"";
  }
  out += ">";
  write_parts(chosen, out);
  out += "</" + name + ">";
}

void GeneratedDocuments::write_parts(const std::string& name, std::string& out) {
  const Type& type = types_.at(name);
  if (!type.base.empty()) write_parts(type.base, out);
  for (const Element& element : type.elements) {
    const int count = element.least + below(element.most - element.least + 1);
    for (int i = 0; i < count; ++i) write(element.name, element.type, out);
  }
}

void GeneratedDocuments::write_value(const std::string& type, std::string& out) {
  if (const auto words = words_.find(type); words != words_.end()) {
    out += words->second[static_cast<std::size_t>(below(static_cast<int>(words->second.size())))];
  } else if (type == "xs:double") {
    append_double(out, number());
  } else if (type == "FractionType") {
    append_double(out, std::uniform_real_distribution(0.0, 1.0)(random_));
  } else if (type == "xs:int") {
    out += std::to_string(static_cast<std::int32_t>(random_() >> below(32)));
  } else if (type == "xs:long") {
    out += std::to_string(static_cast<std::int64_t>(random_() >> below(64)));
  } else if (type == "xs:boolean") {
    out += below(2) == 0 ? "true" : "false";
  } else if (type == "xs:NMTOKEN" || type == "xs:token") {
    out += "n" + std::to_string(below(1000)) + "-a.b_c";
  } else if (type == "xs:string") {
    append_escaped(out, text());
  } else {
    throw std::logic_error("no values of " + type);
  }
}

// Any bits, or what people write.
double GeneratedDocuments::number() {
  switch (below(8)) {
    case 0:
      return std::bit_cast<double>(random_());
    case 1:
      return std::numeric_limits<double>::infinity();
    case 2:
      return -0.0;
    default:
      return below(200'000) / 100.0 - 1000;
  }
}

std::string GeneratedDocuments::text() {
  static constexpr const char* kPieces[] = {
      "a", " ", "&", "<b>", "]]>", "\"", "\n", "\t", "\r", "\xC3\xA4", "\xF0\x9F\xA6\xBE",
      "'", "7"};
  std::string out;
  for (int i = below(8); i > 0; --i) {
    out += kPieces[static_cast<std::size_t>(below(static_cast<int>(std::size(kPieces))))];
  }
  return out;
}

}  // namespace aprsim::crcl
