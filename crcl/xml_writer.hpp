#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "crcl/element_writer.hpp"
#include "crcl/text.hpp"

namespace aprsim::crcl {

/// Writes one document on one line, as the reference servers do: no white space between elements,
/// no attribute but xsi:type.
class XmlWriter final : public ElementWriter {
 public:
  XmlWriter() {
    out_.reserve(4096);  // above the usual size of a status
    out_ += R"(<?xml version="1.0" encoding="UTF-8" standalone="yes"?>)";
  }

  void open(std::string_view name) override { tag("<", name); }
  void open(std::string_view name, std::string_view xsi_type) override {
    out_ += '<';
    out_ += name;
    out_ += R"( xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:type=")";
    append_escaped(out_, xsi_type);
    out_ += "\">";
  }
  void close(std::string_view name) override { tag("</", name); }

  void text(std::string_view name, std::string_view value) override {
    tag("<", name);
    append_escaped(out_, value);
    tag("</", name);
  }
  void number(std::string_view name, double value) override {
    tag("<", name);
    append_double(out_, value);
    tag("</", name);
  }
  void integer(std::string_view name, std::int64_t value) override {
    tag("<", name);
    append_long(out_, value);
    tag("</", name);
  }

  [[nodiscard]] std::string document() && { return std::move(out_); }

 private:
  void tag(std::string_view begin, std::string_view name) {
    out_ += begin;
    out_ += name;
    out_ += '>';
  }

  std::string out_;
};

}  // namespace aprsim::crcl
