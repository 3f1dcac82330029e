#include "clients/aprsim/text/paint.hpp"

#include <fmt/format.h>

namespace aprsim::client {
namespace {

// Attributes of ECMA-48's SGR; colours are the terminal's own.
std::string_view attribute(Tone tone) {
  switch (tone) {
    case Tone::kHeading:
      return "1";
    case Tone::kGood:
      return "32";
    case Tone::kWarning:
      return "33";
    case Tone::kBad:
      return "1;31";
  }
  return "0";
}

}  // namespace

std::string Paint::operator()(Tone tone, std::string_view text) const {
  if (!on_) return std::string(text);
  return fmt::format("\x1b[{}m{}\x1b[0m", attribute(tone), text);
}

}  // namespace aprsim::client
