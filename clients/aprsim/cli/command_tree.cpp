#include "clients/aprsim/cli/command_tree.hpp"

#include <algorithm>
#include <cctype>

namespace aprsim::client {

std::vector<std::string> choices(const OptionInfo& option) {
  if (option.value.find('|') == std::string::npos) return {};
  std::vector<std::string> words;
  for (std::size_t begin = 0; begin <= option.value.size();) {
    const std::size_t end = std::min(option.value.find('|', begin), option.value.size());
    std::string word = option.value.substr(begin, end - begin);
    // Placeholders are in capitals.
    if (std::ranges::any_of(word, [](unsigned char c) { return std::islower(c) != 0; })) {
      words.push_back(std::move(word));
    }
    begin = end + 1;
  }
  return words;
}

}  // namespace aprsim::client
