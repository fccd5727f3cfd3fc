// Closed polygons, smoothed: a low-pass, and a spline that keeps corners and ignores spikes.
#pragma once

#include <Eigen/Core>

namespace kerf::internal {

/// One row per point; the polygon is closed. At least 6 points.
using ClosedCurve = Eigen::MatrixXd;

/// Lengths of the edges from row i to the next, each at least `least`.
Eigen::VectorXd edgeLengths(const ClosedCurve& curve, double least);

/// Minimises sum m |T - R|^2 + (L / 2 pi)^4 sum m |T''|^2: waves shorter than L go. @param edges  > 0, mm.
ClosedCurve lowPass(const ClosedCurve& values, const Eigen::VectorXd& edges, double wave_mm);

/// The same with |T'|^2 and (L / 2 pi)^2: overshoots nowhere.
ClosedCurve firstOrderLowPass(const ClosedCurve& values, const Eigen::VectorXd& edges, double wave_mm);

/// Parameters of the robust spline.
struct RobustSpline {
  double wave_mm;        ///< L
  double outlier_mm;     ///< Huber's limit on |T - R|
  double bend_per_mm;    ///< Huber's limit on |T''|
  double least_edge_mm;  ///< floor of edge lengths
  int rounds = 8;
};

/// lowPass() with Huber's weights on both terms, reweighted; edge lengths are those of the round before.
/// @cost O(points x rounds), 1 ms for 1000 points.
ClosedCurve robustSpline(const ClosedCurve& curve, const RobustSpline& spline);

}  // namespace kerf::internal
