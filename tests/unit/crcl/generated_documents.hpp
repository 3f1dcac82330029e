#pragma once

#include <map>
#include <random>
#include <string>
#include <vector>

namespace aprsim::crcl {

/// Makes documents of the three roots at random, of all that the built-in schemas allow: every
/// type, every element there or not, names of parts, numbers of every size, text with markup.
class GeneratedDocuments {
 public:
  GeneratedDocuments();

  /// The document of that number: always the same. The roots take turns.
  [[nodiscard]] std::string document(unsigned number);

 private:
  struct Element {
    std::string name, type;
    int least = 1, most = 1;
  };
  struct Type {
    std::string base;
    bool abstract = false;
    std::vector<Element> elements;      // of its own
    std::vector<std::string> concrete;  // types that may stand for it, itself included
  };

  void write(const std::string& name, const std::string& type, std::string& out);
  void write_parts(const std::string& type, std::string& out);
  void write_value(const std::string& type, std::string& out);
  [[nodiscard]] int below(int end);
  [[nodiscard]] double number();
  [[nodiscard]] std::string text();

  std::map<std::string, Type> types_;
  std::map<std::string, std::vector<std::string>> words_;  // of enumerations
  std::mt19937_64 random_;
};

}  // namespace aprsim::crcl
