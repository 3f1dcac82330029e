#include "tests/benchmarks/support/table.hpp"

#include <cstdio>
#include <stdexcept>

namespace aprsim::bench {
namespace {

std::string cell_text(const Table::Cell& cell) {
  if (const auto* number = std::get_if<double>(&cell)) return number_text(*number);
  std::string quoted = "\"";
  for (const char c : std::get<std::string>(cell)) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

Table::Table(std::vector<std::string> columns) : columns_(std::move(columns)) {}

void Table::row(std::vector<Cell> cells) {
  if (cells.size() != columns_.size()) throw std::invalid_argument("a cell for every column");
  rows_.push_back(std::move(cells));
}

std::string Table::csv() const {
  std::string out;
  for (std::size_t i = 0; i < columns_.size(); ++i)
    out += (i > 0 ? "," : "") + cell_text(columns_[i]);
  out += '\n';
  for (const auto& cells : rows_) {
    for (std::size_t i = 0; i < cells.size(); ++i) out += (i > 0 ? "," : "") + cell_text(cells[i]);
    out += '\n';
  }
  return out;
}

}  // namespace aprsim::bench
