#include "crcl/xml_writer.hpp"

#include "crcl/text.hpp"

namespace aprsim::crcl {
namespace {

constexpr std::size_t kUsualSize = 4096;

}  // namespace

XmlWriter::XmlWriter() {
  out_.reserve(kUsualSize);
  out_ += R"(<?xml version="1.0" encoding="UTF-8" standalone="yes"?>)";
}

void XmlWriter::open(std::string_view name) {
  out_ += '<';
  out_ += name;
  out_ += '>';
}

void XmlWriter::open(std::string_view name, std::string_view xsi_type) {
  out_ += '<';
  out_ += name;
  out_ += R"( xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:type=")";
  append_escaped(out_, xsi_type);
  out_ += "\">";
}

void XmlWriter::close(std::string_view name) {
  out_ += "</";
  out_ += name;
  out_ += '>';
}

void XmlWriter::text(std::string_view name, std::string_view value) {
  open(name);
  append_escaped(out_, value);
  close(name);
}

void XmlWriter::number(std::string_view name, double value) {
  open(name);
  append_double(out_, value);
  close(name);
}

void XmlWriter::integer(std::string_view name, std::int64_t value) {
  open(name);
  append_long(out_, value);
  close(name);
}

void XmlWriter::flag(std::string_view name, bool value) { text(name, value ? "true" : "false"); }

}  // namespace aprsim::crcl
