#include "clients/aprsim/scenario/report_page.hpp"

#include <cmath>

#include <fmt/format.h>

#include "clients/aprsim/scenario/plot_frame.hpp"

namespace aprsim::client {

const char* const kPageStyle =
    "body{font:15px/1.45 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;"
    "color:#1d2630}table{border-collapse:collapse;margin:.5rem 0 1.5rem}td,th{padding:.15rem "
    ".8rem .15rem 0;text-align:left;border-bottom:1px solid #dde3e8}td.n{text-align:right}"
    ".good{color:#187a3d}.bad{color:#b3261e}svg{max-width:100%;height:auto}"
    "@media(prefers-color-scheme:dark){body{background:#14191e;color:#d9e0e6}"
    "td,th{border-color:#333c44}svg{background:#eef1f4}}";

std::string page_head(const std::string& title) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>{}</title><style>{}</style></head><body>\n",
      escaped_html(title), kPageStyle);
}

std::string page_row(std::initializer_list<std::string> texts, const char* tag) {
  std::string out = "<tr>";
  for (const auto& text : texts) out += fmt::format("<{0}>{1}</{0}>", tag, escaped_html(text));
  return out + "</tr>\n";
}

std::string page_table(std::initializer_list<std::string> titles, const std::string& rows) {
  return rows.empty() ? "" : "<table>" + page_row(titles, "th") + rows + "</table>\n";
}

std::string page_section(const std::string& heading, const std::string& content) {
  return content.empty() ? "" : "<h2>" + escaped_html(heading) + "</h2>\n" + content;
}

std::string figure_text(double value) {
  return value == std::floor(value) && std::abs(value) < 1e9 ? fmt::format("{:.0f}", value)
                                                             : fmt::format("{:.4g}", value);
}

}  // namespace aprsim::client
