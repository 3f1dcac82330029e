#include "crcl/xml_writer.hpp"

#include "crcl/text.hpp"
#include "crcl/xml_tree.hpp"

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

void XmlWriter::subtree(const XmlNode& node) {
  if (node.type.empty()) {
    open(node.name);
  } else {
    open(node.name, node.type);
  }
  if (node.children.empty()) append_escaped(out_, node.text);
  for (const XmlNode& child : node.children) subtree(child);
  close(node.name);
}

std::string XmlWriter::body_of_command(const XmlNode& node) {
  XmlWriter writer{std::string()};
  for (const XmlNode& child : node.children) {
    const bool common = child.name == "Name" || child.name == "CommandID" || child.name == "Guard";
    if (!common) writer.subtree(child);
  }
  return writer.take();
}

}  // namespace aprsim::crcl
