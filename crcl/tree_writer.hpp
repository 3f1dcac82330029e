#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "crcl/element_writer.hpp"
#include "crcl/text.hpp"
#include "crcl/xml_reader.hpp"

namespace aprsim::crcl {

/// Builds the same tree as reading the written document.
class TreeWriter final : public ElementWriter {
 public:
  void open(std::string_view name) override { add(name); }
  void open(std::string_view name, std::string_view xsi_type) override {
    add(name).type = xsi_type;
  }
  void close(std::string_view /*name*/) override { open_.pop_back(); }

  void text(std::string_view name, std::string_view value) override {
    add(name).text = value;
    open_.pop_back();
  }
  void number(std::string_view name, double value) override {
    append_double(add(name).text, value);
    open_.pop_back();
  }
  void integer(std::string_view name, std::int64_t value) override {
    append_long(add(name).text, value);
    open_.pop_back();
  }

  [[nodiscard]] XmlNode root() && { return std::move(root_); }

 private:
  // Addresses of open elements stay good: a sibling is only added once this one is closed.
  XmlNode& add(std::string_view name) {
    XmlNode* node = open_.empty() ? &root_ : &open_.back()->children.emplace_back();
    node->name = name;
    open_.push_back(node);
    return *node;
  }

  XmlNode root_;
  std::vector<XmlNode*> open_;
};

}  // namespace aprsim::crcl
