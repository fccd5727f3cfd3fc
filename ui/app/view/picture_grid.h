// Lines at round numbers of mm over a picture, to read off positions.
#pragma once

#include <string>
#include <vector>

#include "ui/app/view/camera.h"

namespace kerf {

struct PictureGrid {
  struct Line {
    double mm = 0;     ///< to the right or up in the view, from the scan's origin: as kerf pick --at counts
    double pixel = 0;  ///< from the left or from the upper edge of the picture
  };
  double step_mm = 1;               ///< 1, 2 or 5 times a power of ten
  std::vector<Line> right, up;      ///< vertical lines, by their distance to the right; horizontal ones, by their
                                    ///< height
  std::string right_name, up_name;  ///< "x", "-y": the scan's axis in that direction; empty: none
};

/// At least 50 pixels between lines, and at most 24 lines along the longer side.
/// @param camera  parallel projection; its target in the frame of the mesh as drawn.
/// @param drawn_from_scan  the turn of the drawn mesh about the scan's origin (uprightFrame()).
/// @pre  width, height >= 1.
PictureGrid pictureGrid(const Camera& camera, int width, int height, const Eigen::Matrix3d& drawn_from_scan);

/// Label of a line: its mm, with enough decimals to differ from the next line.   @pre  grid.step_mm > 0
std::string numberAt(const PictureGrid& grid, const PictureGrid::Line& line);

}  // namespace kerf
