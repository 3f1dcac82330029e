#include "world/api/faults/fault_when.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "world/api/faults/fault_kinds.hpp"

namespace aprsim::faults {
namespace {

constexpr std::string_view kForms =
    "placed:TYPE[:ROBOT], grasp:ROBOT[:N], beam:EYE, event:NAME or QUANTITY[:ROBOT[:JOINT]] with > "
    "or < and a limit";

template <typename Number>
std::optional<Number> whole_number(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::vector<std::string> split(std::string_view text) {
  std::vector<std::string> out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(':', begin), text.size());
    out.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

tl::unexpected<std::string> no_form(const std::string& text) {
  return tl::unexpected("'" + text + "' is none of " + std::string(kForms));
}

tl::expected<FaultWhen, std::string> parse_crossing(const std::string& text, std::size_t sign) {
  const auto words = split(std::string_view(text).substr(0, sign));
  const auto limit = whole_number<double>(std::string_view(text).substr(sign + 1));
  if (!limit || !std::isfinite(*limit)) {
    return tl::unexpected("'" + text + "' has no finite number for a limit");
  }
  const QuantityInfo* quantity = find_quantity(words[0]);
  if (quantity == nullptr) {
    std::string names;
    for (const auto& known : all_quantities()) {
      names += (names.empty() ? "" : ", ") + std::string(known.name);
    }
    return tl::unexpected("'" + words[0] + "' is no quantity; there are: " + names);
  }
  const bool of_joint = quantity->quantity == Quantity::kJointPosition;
  const std::size_t wanted = 1 + (quantity->of_robot ? 1 : 0) + (of_joint ? 1 : 0);
  if (words.size() != wanted) {
    return tl::unexpected("'" + text + "' is not " + words[0] +
                          (quantity->of_robot ? ":ROBOT" : "") + (of_joint ? ":JOINT" : "") +
                          " with > or < and a limit");
  }
  WhenCrossing out{.quantity = words[0], .robot = {}, .above = text[sign] == '>', .limit = *limit};
  if (quantity->of_robot) out.robot = words[1];
  if (of_joint) {
    const auto joint = whole_number<unsigned>(words[2]);
    if (!joint || *joint == 0) {
      return tl::unexpected("'" + words[2] + "' is no number of a joint, from 1");
    }
    out.joint = *joint;
  }
  return out;
}

}  // namespace

tl::expected<FaultWhen, std::string> parse_when(const std::string& text) {
  const std::size_t sign = text.find_first_of("<>");
  if (sign != std::string::npos) return parse_crossing(text, sign);
  const auto words = split(text);
  for (const auto& word : words) {
    if (word.empty()) return no_form(text);
  }
  if (words[0] == "placed" && (words.size() == 2 || words.size() == 3)) {
    return WhenPlaced{words[1], words.size() == 3 ? words[2] : ""};
  }
  if (words[0] == "grasp" && (words.size() == 2 || words.size() == 3)) {
    const auto count = words.size() == 3 ? whole_number<unsigned>(words[2]) : 1U;
    if (!count || *count == 0) {
      return tl::unexpected("'" + words[2] + "' is no number of a grasp, from 1");
    }
    return WhenGrasped{words[1], *count};
  }
  if (words[0] == "beam" && words.size() == 2) return WhenBeamBroken{words[1]};
  if (words[0] == "event" && words.size() == 2) return WhenReported{words[1]};
  return no_form(text);
}

}  // namespace aprsim::faults
