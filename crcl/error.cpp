#include "crcl/error.hpp"

namespace aprsim::crcl {

std::string Error::message() const {
  std::string text = element;
  if (!value.empty()) text += (text.empty() ? "'" : ": '") + value + "'";
  if (!expected.empty()) text += (text.empty() ? "" : ": ") + expected;
  return text;
}

}  // namespace aprsim::crcl
