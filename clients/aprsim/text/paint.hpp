#pragma once

#include <string>
#include <string_view>

namespace aprsim::client {

enum class Tone { kHeading, kGood, kWarning, kBad };

/// Colours text for a terminal; returns it unchanged when off.
class Paint {
 public:
  Paint() = default;
  explicit Paint(bool on) : on_(on) {}
  [[nodiscard]] bool on() const { return on_; }
  [[nodiscard]] std::string operator()(Tone tone, std::string_view text) const;

 private:
  bool on_ = false;
};

}  // namespace aprsim::client
