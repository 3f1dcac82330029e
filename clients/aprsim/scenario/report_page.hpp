#pragma once

#include <initializer_list>
#include <string>

/// Elements of the HTML pages of reports.
namespace aprsim::client {

extern const char* const kPageStyle;

/// The page up to the beginning of its body.
[[nodiscard]] std::string page_head(const std::string& title);
/// A row of a table; escapes the texts.
[[nodiscard]] std::string page_row(std::initializer_list<std::string> texts,
                                   const char* tag = "td");
/// A table; empty without rows.
[[nodiscard]] std::string page_table(std::initializer_list<std::string> titles,
                                     const std::string& rows);
/// A heading with its content; empty without content.
[[nodiscard]] std::string page_section(const std::string& heading, const std::string& content);
/// Formats counts as integers and other numbers with four digits.
[[nodiscard]] std::string figure_text(double value);

}  // namespace aprsim::client
