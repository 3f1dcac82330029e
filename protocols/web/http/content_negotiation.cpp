#include "protocols/web/http/content_negotiation.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include "protocols/web/http/origin_check.hpp"

namespace aprsim::web {
namespace {

constexpr std::string_view kBlank = " \t";

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

/// Removes the part up to `separator` from `rest` and returns it without blanks.
std::string_view next_part(std::string_view& rest, char separator) {
  const std::size_t end = std::min(rest.find(separator), rest.size());
  const std::string_view part = trimmed(rest.substr(0, end));
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return part;
}

/// Weight of the parameters behind a coding ("q=0.5"): 1 by default, 0 where it is malformed, since
/// the uncompressed file is always right.
double weight_of(std::string_view parameters) {
  while (!parameters.empty()) {
    const std::string_view parameter = next_part(parameters, ';');
    if (!is_equal_ignoring_case(parameter.substr(0, 2), "q=")) continue;
    const std::string_view text = parameter.substr(2);
    double weight = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), weight);
    const bool valid = error == std::errc() && end == text.data() + text.size();
    return valid && weight >= 0 && weight <= 1 ? weight : 0;
  }
  return 1;
}

std::string_view without_weakness(std::string_view etag) {
  if (etag.starts_with("W/")) etag.remove_prefix(2);
  return etag;
}

/// Removes the next entity tag from `rest`; empty where there is none. A tag may contain commas.
std::string_view next_etag(std::string_view& rest) {
  rest = rest.substr(std::min(rest.find_first_not_of(", \t"), rest.size()));
  const std::size_t open = rest.starts_with("W/") ? 2 : 0;
  if (rest.size() <= open || rest[open] != '"') return {};
  const std::size_t close = rest.find('"', open + 1);
  if (close == std::string_view::npos) return {};
  const std::string_view etag = rest.substr(0, close + 1);
  rest.remove_prefix(close + 1);
  return etag;
}

}  // namespace

bool accepts_gzip(std::string_view accept_encoding) {
  std::optional<double> named, any;
  while (!accept_encoding.empty()) {
    std::string_view parameters = next_part(accept_encoding, ',');
    const std::string_view coding = next_part(parameters, ';');
    if (is_equal_ignoring_case(coding, "gzip") || is_equal_ignoring_case(coding, "x-gzip")) {
      named = weight_of(parameters);
    } else if (coding == "*") {
      any = weight_of(parameters);
    }
  }
  return named.value_or(any.value_or(0)) > 0;
}

bool matches_etag(std::string_view if_none_match, std::string_view etag) {
  if (trimmed(if_none_match) == "*") return true;
  for (;;) {
    const std::string_view candidate = next_etag(if_none_match);
    if (candidate.empty()) return false;
    if (without_weakness(candidate) == without_weakness(etag)) return true;
  }
}

}  // namespace aprsim::web
