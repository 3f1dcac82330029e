#include "clients/wires/vision_frame.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace aprsim::client {
namespace {

constexpr std::size_t kFields = 6;
constexpr double kMetresPerMillimetre = 1e-3;

/// The fields between commas, without the blanks after these; a last empty one is left out.
std::vector<std::string_view> fields_of(std::string_view line) {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
  std::vector<std::string_view> fields;
  while (!line.empty()) {
    const std::size_t comma = std::min(line.find(','), line.size());
    fields.push_back(line.substr(0, comma));
    line.remove_prefix(std::min(comma + 1, line.size()));
    line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  }
  return fields;
}

std::optional<double> number_of(std::string_view text) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  if (read.ec != std::errc() || read.ptr != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

Outcome<std::vector<VisionObject>> decode_vision_line(std::string_view line) {
  const auto fields = fields_of(line);
  if (fields.size() % kFields != 0) {
    return failed(FailureKind::kConnection,
                  fmt::format("a vision line of {} fields, which is no multiple of {}",
                              fields.size(), kFields));
  }
  std::vector<VisionObject> objects;
  for (std::size_t at = 0; at < fields.size(); at += kFields) {
    VisionObject object{.name = std::string(fields[at]), .kind = std::string(fields[at + 5])};
    std::array<double, 4> numbers{};
    object.detected = true;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      const std::string_view text = fields[at + 1 + k];
      const auto number = number_of(text);
      if (!number && !text.empty()) {
        return failed(FailureKind::kConnection,
                      fmt::format("a vision line has '{}' instead of a number", text));
      }
      object.detected = object.detected && number;
      numbers[k] = number.value_or(0);
    }
    if (object.detected) {
      object.rotation_rad = numbers[0];
      object.x_m = numbers[1] * kMetresPerMillimetre;
      object.y_m = numbers[2] * kMetresPerMillimetre;
      object.score = numbers[3];
    }
    objects.push_back(std::move(object));
  }
  return objects;
}

}  // namespace aprsim::client
