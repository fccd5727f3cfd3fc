// The sheet of a workshop drawing, as SVG: a side view to scale, dimensions beside it, head lines and a scale bar.
#pragma once

#include <string>
#include <vector>

#include "geometry/tool/tool.h"

namespace kerf::internal {

/// A length for drawings: at most two decimals.
std::string mm(double value);

/// Drawing coordinates: x to the right and y upwards, mm; the tip's level is y = 0. Places on the sheet: px from its
/// upper left corner.
class Sheet {
 public:
  using Point = Eigen::Vector2d;  ///< mm

  static constexpr const char *kCutting = "#e0b040", *kBody = "#d4d9df", *kInk = "#1d2733", *kDimension = "#2a5c8a";
  static constexpr double kPageWidth = 720, kPageHeight = 900, kTop = 116, kBottom = 70, kFont = 17;  // px

  /// Fits `width` x `height` mm between the margins, at most `most_width` px wide; x = 0 comes at `middle` px.
  Sheet(double width, double height, double most_width, double middle);

  double scale() const { return scale_; }  ///< px per mm
  double x(double mm) const { return middle_ + scale_ * mm; }
  double y(double mm) const { return kPageHeight - kBottom - scale_ * mm; }
  /// Puts x = 0 at another place of the sheet.
  void moveTo(double px) { middle_ = px; }

  void polygon(const std::vector<Point>& outline, const char* fill, const char* extra = "");
  void line(double x0, double y0, double x1, double y1, const char* color, const char* extra = "");  // px
  void text(double px, double py, const std::string& what, const char* color, const char* anchor, double size = kFont);
  void centreLine(double low, double high);
  /// The dimension `what` between two heights, its line at `column` px to the right; both ends get extension lines.
  void tall(double from_x, double low, double high, double column, const std::string& what);
  /// A width at a height of the drawing, its line and number to the left, from `column` px on.
  void wide(double low_x, double high_x, double at, double column, const std::string& what);
  void breakLine(double low, double high, double at);

  /// The whole file: name, second line, ISO 6360, scale bar and the drawing.
  std::string finished(const Tool& tool, const std::string& second_line);

 private:
  void arrow(double x0, double y0, double x1, double y1);
  void scaleBar();

  double scale_, middle_;
  std::string body_;
};

/// The drawing of a bur or a disc. @param second_line  below its name.   @pre tool.head and tool.cutting.
std::string drawRevolved(const Tool& tool, const std::string& second_line);

}  // namespace kerf::internal
