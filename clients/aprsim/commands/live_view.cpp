#include "clients/aprsim/commands/live_view.hpp"

#include <algorithm>
#include <ostream>
#include <sys/ioctl.h>
#include <unistd.h>

#include <fmt/format.h>

namespace aprsim::client {

std::string cut_to_width(std::string_view line, std::size_t columns) {
  std::string out;
  std::size_t width = 0;
  for (std::size_t i = 0; i < line.size();) {
    if (line[i] == '\x1b') {
      const std::size_t end = std::min(line.find('m', i), line.size() - 1) + 1;
      out += line.substr(i, end - i);
      i = end;
      continue;
    }
    std::size_t next = i + 1;
    while (next < line.size() && (static_cast<unsigned char>(line[next]) & 0xC0) == 0x80) ++next;
    if (width++ < columns) out += line.substr(i, next - i);
    i = next;
  }
  return out;
}

void LiveView::show(const std::string& text) {
  winsize size{};
  const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 1;
  // Default for terminals that do not report their size.
  show(text, known ? size.ws_row : 24, known && size.ws_col > 0 ? size.ws_col : 80);
}

void LiveView::show(const std::string& text, std::size_t rows, std::size_t columns) {
  if (shown_lines_ > 0) out_ << fmt::format("\x1b[{}A", shown_lines_);
  std::size_t lines = 0;
  // The cursor's line stays free: one more line would scroll the terminal.
  for (std::size_t i = 0; i < text.size() && lines + 1 < rows; ++lines) {
    const std::size_t end = std::min(text.find('\n', i), text.size());
    out_ << '\r' << cut_to_width(std::string_view(text).substr(i, end - i), columns) << "\x1b[K\n";
    i = end + 1;
  }
  out_ << "\x1b[J";
  shown_lines_ = lines;
}

}  // namespace aprsim::client
