#pragma once

#include <string>
#include <string_view>

namespace aprsim::client {

enum class Tone { kHeading, kGood, kWarning, kBad };

/// Colours of text for a terminal; leaves it as it is when off.
class Paint {
 public:
  Paint() = default;
  explicit Paint(bool on) : on_(on) {}
  [[nodiscard]] std::string operator()(Tone tone, std::string_view text) const;

 private:
  bool on_ = false;
};

}  // namespace aprsim::client
