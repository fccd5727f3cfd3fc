#include "preprocess/close/smooth_curve.h"

#include <algorithm>
#include <numbers>
#include <vector>

namespace kerf::internal {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// A symmetric positive definite matrix with two cyclic bands beside the diagonal.
struct CyclicPentadiagonal {
  VectorXd diagonal, next, next_but_one;  ///< (i, i), (i, i + 1), (i, i + 2); indices modulo the size

  explicit CyclicPentadiagonal(Index n)
      : diagonal(VectorXd::Zero(n)), next(VectorXd::Zero(n)), next_but_one(VectorXd::Zero(n)) {}

  ClosedCurve solve(const ClosedCurve& right) const;
};

/// The last two unknowns border a plain band matrix, which L D L^T solves for the right-hand sides and both columns.
ClosedCurve CyclicPentadiagonal::solve(const ClosedCurve& right) const {
  const Index n = diagonal.size(), m = n - 2, columns = right.cols();
  ClosedCurve x(m, columns + 2);
  x.leftCols(columns) = right.topRows(m);
  x.rightCols(2).setZero();
  x(0, columns) += next_but_one[n - 2];
  x(m - 1, columns) += next[m - 1];
  x(m - 2, columns) += next_but_one[m - 2];
  x(0, columns + 1) += next[n - 1];
  x(1, columns + 1) += next_but_one[n - 1];
  x(m - 1, columns + 1) += next_but_one[m - 1];
  const ClosedCurve border = x.rightCols(2);

  VectorXd d(m), below = VectorXd::Zero(m), below_2 = VectorXd::Zero(m);
  for (Index i = 0; i < m; ++i) {
    d[i] = diagonal[i];
    if (i >= 1) d[i] -= below[i - 1] * below[i - 1] * d[i - 1];
    if (i >= 2) d[i] -= below_2[i - 2] * below_2[i - 2] * d[i - 2];
    if (i + 1 < m) below[i] = (next[i] - (i >= 1 ? below[i - 1] * d[i - 1] * below_2[i - 1] : 0)) / d[i];
    if (i + 2 < m) below_2[i] = next_but_one[i] / d[i];
  }

  for (Index c = 0; c < x.cols(); ++c) {
    for (Index i = 0; i < m; ++i) {
      if (i >= 1) x(i, c) -= below[i - 1] * x(i - 1, c);
      if (i >= 2) x(i, c) -= below_2[i - 2] * x(i - 2, c);
    }
    for (Index i = m; i-- > 0;) {
      x(i, c) /= d[i];
      if (i + 1 < m) x(i, c) -= below[i] * x(i + 1, c);
      if (i + 2 < m) x(i, c) -= below_2[i] * x(i + 2, c);
    }
  }

  Eigen::Matrix2d schur;
  schur << diagonal[n - 2], next[n - 2], next[n - 2], diagonal[n - 1];
  schur -= border.transpose() * x.rightCols(2);
  const double determinant = schur(0, 0) * schur(1, 1) - schur(0, 1) * schur(1, 0);
  Eigen::Matrix2d inverse;
  inverse << schur(1, 1), -schur(0, 1), -schur(1, 0), schur(0, 0);
  inverse /= determinant;

  ClosedCurve out(n, columns);
  out.bottomRows(2) = inverse * (right.bottomRows(2) - border.transpose() * x.leftCols(columns));
  out.topRows(m) = x.leftCols(columns) - x.rightCols(2) * out.bottomRows(2);
  return out;
}

/// Second derivative by finite differences at one point.
struct Stencil {
  Index before, at, after;
  double c_before, c_at, c_after;
  double mass;  ///< length of curve per point, mm
};

Stencil stencilAt(const VectorXd& edges, Index i) {
  const Index n = edges.size(), before = (i + n - 1) % n;
  const double left = edges[before], right = edges[i], both = left + right;
  const double c_before = 2 / (both * left), c_after = 2 / (both * right);
  return {before, i, (i + 1) % n, c_before, -(c_before + c_after), c_after, both / 2};
}

/// One weighted solve.
ClosedCurve solveWeighted(const ClosedCurve& values, const VectorXd& edges, double wave, const VectorXd& data_weight,
                          const VectorXd& bend_weight) {
  const double lambda = wave / (2 * std::numbers::pi);
  const double lambda4 = lambda * lambda * lambda * lambda;
  CyclicPentadiagonal a(values.rows());
  ClosedCurve right(values.rows(), values.cols());
  for (Index i = 0; i < values.rows(); ++i) {
    const Stencil s = stencilAt(edges, i);
    const double k = lambda4 * s.mass * bend_weight[i];
    a.diagonal[s.before] += k * s.c_before * s.c_before;
    a.diagonal[s.at] += k * s.c_at * s.c_at + s.mass * data_weight[i];
    a.diagonal[s.after] += k * s.c_after * s.c_after;
    a.next[s.before] += k * s.c_before * s.c_at;
    a.next[s.at] += k * s.c_at * s.c_after;
    a.next_but_one[s.before] += k * s.c_before * s.c_after;
    right.row(i) = s.mass * data_weight[i] * values.row(i);
  }
  return a.solve(right);
}

}  // namespace

VectorXd edgeLengths(const ClosedCurve& curve, double least) {
  VectorXd out(curve.rows());
  for (Index i = 0; i < curve.rows(); ++i)
    out[i] = std::max(least, (curve.row((i + 1) % curve.rows()) - curve.row(i)).norm());
  return out;
}

ClosedCurve lowPass(const ClosedCurve& values, const VectorXd& edges, double wave_mm) {
  const VectorXd ones = VectorXd::Ones(values.rows());
  return solveWeighted(values, edges, wave_mm, ones, ones);
}

ClosedCurve firstOrderLowPass(const ClosedCurve& values, const VectorXd& edges, double wave_mm) {
  const double lambda = wave_mm / (2 * std::numbers::pi);
  CyclicPentadiagonal a(values.rows());
  ClosedCurve right(values.rows(), values.cols());
  for (Index i = 0; i < values.rows(); ++i) {
    const Stencil s = stencilAt(edges, i);
    const double k = lambda * lambda / edges[i];
    a.diagonal[i] += s.mass + k;
    a.diagonal[s.after] += k;
    a.next[i] -= k;
    right.row(i) = s.mass * values.row(i);
  }
  return a.solve(right);
}

ClosedCurve robustSpline(const ClosedCurve& curve, const RobustSpline& spline) {
  VectorXd data_weight = VectorXd::Ones(curve.rows()), bend_weight = data_weight;
  VectorXd edges = edgeLengths(curve, spline.least_edge_mm);
  ClosedCurve t = curve;
  for (int round = 0; round < spline.rounds; ++round) {
    t = solveWeighted(curve, edges, spline.wave_mm, data_weight, bend_weight);
    edges = edgeLengths(t, spline.least_edge_mm);
    for (Index i = 0; i < curve.rows(); ++i) {
      const Stencil s = stencilAt(edges, i);
      const double bend = (s.c_before * t.row(s.before) + s.c_at * t.row(s.at) + s.c_after * t.row(s.after)).norm();
      data_weight[i] = 1 / std::max(1.0, (t.row(i) - curve.row(i)).norm() / spline.outlier_mm);
      bend_weight[i] = 1 / std::max(1.0, bend / spline.bend_per_mm);
    }
  }
  return t;
}

}  // namespace kerf::internal
