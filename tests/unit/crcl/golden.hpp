#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace aprsim::crcl {

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + path.string());
  std::ostringstream content;
  content << in.rdbuf();
  return content.str();
}

/// A golden document of tests/contract/crcl: the exact bytes on the wire (one line; the file's
/// final line feed is not part of it).
inline std::string golden(const std::string& name) {
  std::string text =
      read_file(std::filesystem::path(APRSIM_SOURCE_DIR) / "tests/contract/crcl" / name);
  if (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

}  // namespace aprsim::crcl
