// A line drawn over the picture of an import to cut a part of the scan away. No drawing, no window.
#pragma once

#include <string>
#include <vector>

#include "ui/app/view/piece_gizmo.h"

namespace kerf {

class TrimDrawing {
 public:
  enum class What {
    kNothing,
    kLasso,  ///< a closed line around the part
    kLine,   ///< a straight line across the scan
  };

  /// Discards an unfinished line.
  void begin(What what);
  What what() const { return what_; }
  bool isOn() const { return what_ != What::kNothing; }
  /// One line for the user; empty: nothing is drawn.
  std::string hint() const;

  /// The button goes down, moves and goes up, at pixels of the picture.
  void press(const Pixel& at);
  void move(const Pixel& at);
  /// @return the corners of the lasso, or both ends of the line; empty: too short for a cut. The next line can be
  /// drawn.
  std::vector<Pixel> release();

  bool isDrawing() const { return !points_.empty(); }
  const std::vector<Pixel>& points() const { return points_; }

 private:
  What what_ = What::kNothing;
  std::vector<Pixel> points_;
};

}  // namespace kerf
