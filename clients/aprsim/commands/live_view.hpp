#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>
#include <string_view>

namespace aprsim::client {

/// Text that is shown again and again in the same place of a terminal. What was shown last stays.
class LiveView {
 public:
  explicit LiveView(std::ostream& out) : out_(out) {}

  /// Shows whole lines in place of those before, cut to the terminal's present size.
  void show(const std::string& text);
  /// The same for a size that is known.
  void show(const std::string& text, std::size_t rows, std::size_t columns);

 private:
  std::ostream& out_;
  std::size_t shown_lines_ = 0;
};

/// The first `columns` characters of a line in UTF-8; sequences that colour it count nothing and
/// are all kept.
[[nodiscard]] std::string cut_to_width(std::string_view line, std::size_t columns);

}  // namespace aprsim::client
