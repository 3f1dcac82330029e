#pragma once

#include <string>

namespace aprsim::client {

/// An SVG plot with two axes. Coordinates are in the units of the axes.
class PlotFrame {
 public:
  static constexpr double kWidth = 860, kLeft = 60, kRight = 15, kTop = 10, kBottom = 36;
  static constexpr const char* kBlue = "#2767a8";

  struct Axis {
    double min = 0, max = 1;
    std::string title;  ///< empty on y = no marks
  };

  PlotFrame(double height, Axis x, Axis y);
  /// Both axes begin at zero.
  PlotFrame(double height, double max_x, double max_y, const char* x_title, const char* y_title)
      : PlotFrame(height, Axis{0, max_x, x_title}, Axis{0, max_y, y_title}) {}

  /// Position on the page in pixels.
  [[nodiscard]] double x(double value) const;
  [[nodiscard]] double y(double value) const;

  void band(double from_x, double to_x, double from_y, double to_y, const char* colour,
            double opacity, const std::string& title);
  void line(double at_x, const char* colour, const std::string& title);
  /// A horizontal line with its title on it.
  void level(double at_y, const std::string& title);
  void dot(double at_x, double at_y, const std::string& title);
  /// A value with its confidence interval.
  void bar(double at_x, double at_y, double low, double high, const std::string& title);
  void add(const std::string& element) { out_ += element; }
  [[nodiscard]] std::string text() const { return out_ + "</svg>\n"; }

 private:
  double height_, top_;
  Axis x_, y_;
  std::string out_;
};

/// The text with the special characters of HTML and SVG escaped.
[[nodiscard]] std::string escaped_html(const std::string& text);

}  // namespace aprsim::client
