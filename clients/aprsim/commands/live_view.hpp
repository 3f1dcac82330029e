#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>
#include <string_view>

namespace aprsim::client {

/// Text that is updated in place on a terminal. The last text stays.
class LiveView {
 public:
  explicit LiveView(std::ostream& out) : out_(out) {}

  /// Replaces the previous lines, cut to the terminal's present size.
  void show(const std::string& text);
  /// The same for a given size.
  void show(const std::string& text, std::size_t rows, std::size_t columns);

 private:
  std::ostream& out_;
  std::size_t shown_lines_ = 0;
};

/// The first `columns` characters of a line in UTF-8. Colour sequences do not count and are kept.
[[nodiscard]] std::string cut_to_width(std::string_view line, std::size_t columns);

}  // namespace aprsim::client
