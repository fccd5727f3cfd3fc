// Thickness of a base: its section, and the places out of reach of a disc.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "preprocess/close/close.h"

namespace kerf {

/// A section of a solid parallel to its base, `above` mm over it, as squares of 0.05 mm.
class BaseSection {
 public:
  BaseSection(const Solid& s, double above) {
    const Vec3d w = *s.report.base_direction;
    const double level = s.report.base_level_mm - above;
    int axis = 0;
    w.cwiseAbs().maxCoeff(&axis);
    const auto inPlan = [&](const Vec3d& p) { return Eigen::Vector2d(p[(axis + 1) % 3], p[(axis + 2) % 3]); };

    // The outline.
    std::vector<std::array<Eigen::Vector2d, 2>> lines;
    Box3 box;
    for (std::size_t t = 0; t < s.mesh.triangles.size(); ++t) {
      std::vector<Eigen::Vector2d> ends;
      for (int k = 0; k < 3; ++k) {
        const Vec3d a = s.mesh.corner(t, k), b = s.mesh.corner(t, (k + 1) % 3);
        const double da = a.dot(w) - level, db = b.dot(w) - level;
        if ((da < 0) != (db < 0)) ends.push_back(inPlan(a + da / (da - db) * (b - a)));
      }
      if (ends.size() != 2) continue;
      lines.push_back({ends[0], ends[1]});
      for (const Eigen::Vector2d& p : ends) box.add({p.x(), p.y(), 0});
    }

    // The inside, row by row.
    constexpr int kBorder = 10;
    low_ = box.min.head<2>() - Eigen::Vector2d::Constant(kBorder * kSquare);
    columns_ = static_cast<int>(box.size().x() / kSquare) + 2 * kBorder;
    rows_ = static_cast<int>(box.size().y() / kSquare) + 2 * kBorder;
    inside_.assign(static_cast<std::size_t>(columns_ * rows_), 0);
    for (int row = 0; row < rows_; ++row) {
      const double y = low_.y() + (row + 0.5) * kSquare;
      std::vector<double> crossings;
      for (const auto& [p, q] : lines)
        if ((p.y() < y) != (q.y() < y)) crossings.push_back(p.x() + (y - p.y()) / (q.y() - p.y()) * (q.x() - p.x()));
      std::sort(crossings.begin(), crossings.end());
      for (int column = 0; column < columns_; ++column) {
        const double x = low_.x() + (column + 0.5) * kSquare;
        const auto before = std::lower_bound(crossings.begin(), crossings.end(), x) - crossings.begin();
        inside_[at(column, row)] = before % 2 != 0;
      }
    }
  }

  /// Number of places out of reach of a disc of that width and larger than 0.02 mm2. A corner leaves less.
  int thinPlaces(double width) const {
    std::vector<std::array<int, 2>> disc;
    const int reach = static_cast<int>(width / 2 / kSquare);
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x)
        if (std::hypot(x, y) * kSquare <= width / 2) disc.push_back({x, y});
    std::vector<char> reached(inside_.size(), 0);
    for (int row = reach; row + reach < rows_; ++row)
      for (int column = reach; column + reach < columns_; ++column) {
        const auto fits = [&](const std::array<int, 2>& d) { return inside_[at(column + d[0], row + d[1])] != 0; };
        if (!std::all_of(disc.begin(), disc.end(), fits)) continue;
        for (const auto& d : disc) reached[at(column + d[0], row + d[1])] = 1;
      }

    int places = 0;
    std::vector<char> seen = reached;
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column)
        places += sizeOfPlace(column, row, seen) * kSquare * kSquare > 0.02;
    return places;
  }

 private:
  static constexpr double kSquare = 0.05;
  std::size_t at(int column, int row) const { return static_cast<std::size_t>(row * columns_ + column); }

  /// Visits all inside squares connected with this one.
  int sizeOfPlace(int column, int row, std::vector<char>& seen) const {
    std::vector<std::array<int, 2>> stack{{column, row}};
    int size = 0;
    while (!stack.empty()) {
      const auto [x, y] = stack.back();
      stack.pop_back();
      if (x < 0 || y < 0 || x >= columns_ || y >= rows_ || !inside_[at(x, y)] || seen[at(x, y)]) continue;
      seen[at(x, y)] = 1;
      ++size;
      for (const auto& next : {std::array{x + 1, y}, std::array{x - 1, y}, std::array{x, y + 1}, std::array{x, y - 1}})
        stack.push_back(next);
    }
    return size;
  }

  Eigen::Vector2d low_;
  int columns_ = 0, rows_ = 0;
  std::vector<char> inside_;
};

}  // namespace kerf
