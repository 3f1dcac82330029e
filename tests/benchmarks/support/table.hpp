#pragma once

#include <initializer_list>
#include <string>
#include <variant>
#include <vector>

namespace aprsim::bench {

/// Rows of text and numbers under named columns: written as CSV, and shown in RESULTS.md when
/// asked.
class Table {
 public:
  using Cell = std::variant<std::string, double>;

  explicit Table(std::vector<std::string> columns);

  /// Throws std::invalid_argument when there are not as many cells as columns.
  void row(std::vector<Cell> cells);

  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  [[nodiscard]] const std::vector<std::vector<Cell>>& rows() const { return rows_; }
  /// Comma separated, one header line, numbers with as many digits as they need to be told apart.
  [[nodiscard]] std::string csv() const;

 private:
  std::vector<std::string> columns_;
  std::vector<std::vector<Cell>> rows_;
};

/// A number as CSV and plots print it: six significant digits.
std::string number_text(double value);

}  // namespace aprsim::bench
