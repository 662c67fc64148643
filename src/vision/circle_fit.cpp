#include "bearing_calibration/vision/circle_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kParameters = 3;
constexpr double kTukey = 4.685;           // 95 % of least squares' efficiency on Gaussian errors
constexpr double kSigmaOfMad = 1.4826;     // of a Gaussian: sigma over the median of the sizes
constexpr double kLeastScatter_px = 1e-3;  // keeps the weights finite on perfect points

/// A point's distance from the circle and its derivative by (centre u, centre v, radius).
struct Residual {
  double value_px;
  Vector3d gradient;
};
Residual residualOf(const Circle& circle, const Vector2d& point_px) {
  const Vector2d from_centre = point_px - circle.centre_px;
  const double distance_px = std::max(from_centre.norm(), kLeastScatter_px);
  const Vector2d outward = from_centre / distance_px;
  return {distance_px - circle.radius_px, {-outward.x(), -outward.y(), -1.0}};
}

double scatterOf(const std::vector<Vector2d>& points_px, const Circle& circle) {
  std::vector<double> sizes;
  for (const Vector2d& point : points_px) {
    sizes.push_back(std::abs(residualOf(circle, point).value_px));
  }
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return std::max(kLeastScatter_px, kSigmaOfMad * *middle);
}

/// Tukey's weight, 0 for a stranger, and the derivative of weight * residual.
struct Influence {
  double weight;
  double slope;
};
Influence influenceOf(double residual_px, double scatter_px) {
  const double part = std::pow(residual_px / (kTukey * scatter_px), 2);
  if (part >= 1.0) return {0.0, 0.0};
  return {(1.0 - part) * (1.0 - part), (1.0 - part) * (1.0 - 5.0 * part)};
}

/// One reweighted Gauss-Newton step; none when the points leave a direction open.
std::optional<Vector3d> stepFrom(const std::vector<Vector2d>& points_px, const Circle& circle,
                                 double scatter_px) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const Vector2d& point : points_px) {
    const Residual residual = residualOf(circle, point);
    const double weight = influenceOf(residual.value_px, scatter_px).weight;
    normal += weight * residual.gradient * residual.gradient.transpose();
    right -= weight * residual.value_px * residual.gradient;
  }
  constexpr double kLeastInformation = 1e-6;  // an arc of a few degrees has less
  const Eigen::FullPivLU<Matrix3d> solver(normal);
  if (!(std::abs(normal.determinant()) > kLeastInformation)) return std::nullopt;
  return solver.solve(right);
}

/// Of an estimate from groups of neighbours that may err together (cluster-robust "sandwich").
Matrix3d covarianceOf(const std::vector<Vector2d>& points_px, const CircleFit& fit) {
  constexpr int kGroups = 36;
  std::vector<Vector3d> groups(kGroups, Vector3d::Zero());
  Matrix3d bread = Matrix3d::Zero();
  for (const Vector2d& point : points_px) {
    const Residual residual = residualOf(fit.circle, point);
    const Influence influence = influenceOf(residual.value_px, fit.scatter_px);
    const Vector2d from_centre = point - fit.circle.centre_px;
    const double turn = 0.5 + std::atan2(from_centre.y(), from_centre.x()) / (2.0 * kPi);
    const int group = std::min(kGroups - 1, static_cast<int>(turn * kGroups));
    groups[static_cast<std::size_t>(group)] +=
        influence.weight * residual.value_px * residual.gradient;
    bread += influence.slope * residual.gradient * residual.gradient.transpose();
  }
  Matrix3d filling = Matrix3d::Zero();
  int used = 0;
  for (const Vector3d& group : groups) {
    filling += group * group.transpose();
    used += group.isZero(0.0) ? 0 : 1;
  }
  const int free = std::max(1, used - static_cast<int>(kParameters));
  const Matrix3d inverse = bread.inverse();
  return static_cast<double>(used) / free * inverse * filling * inverse;
}

}  // namespace

std::optional<Circle> circleThrough(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  // |p - centre|^2 is the same for all three: two linear equations for the centre from a.
  Eigen::Matrix2d sides;
  sides << (b - a).transpose(), (c - a).transpose();
  constexpr double kLeastArea_px2 = 1e-9;
  if (!(std::abs(sides.determinant()) > kLeastArea_px2)) return std::nullopt;
  const Vector2d right(0.5 * (b - a).squaredNorm(), 0.5 * (c - a).squaredNorm());
  const Vector2d from_a = sides.inverse() * right;
  return Circle{a + from_a, from_a.norm()};
}

std::optional<CircleFit> fitCircle(const std::vector<Vector2d>& points_px, const Circle& start) {
  constexpr int kMostSteps = 50;
  constexpr double kSettled_px = 1e-6;
  if (points_px.size() <= kParameters) return std::nullopt;
  CircleFit fit;
  fit.circle = start;
  for (int i = 0; i < kMostSteps; ++i) {
    fit.scatter_px = scatterOf(points_px, fit.circle);
    const std::optional<Vector3d> step = stepFrom(points_px, fit.circle, fit.scatter_px);
    if (!step) return std::nullopt;
    fit.circle.centre_px += step->head<2>();
    fit.circle.radius_px += step->z();
    if (step->norm() < kSettled_px) break;
  }
  fit.covariance_px2 = covarianceOf(points_px, fit);
  for (const Vector2d& point : points_px) {
    const double residual_px = residualOf(fit.circle, point).value_px;
    fit.belongs.push_back(influenceOf(residual_px, fit.scatter_px).weight > 0.0);
  }
  const bool determined = fit.circle.radius_px > 0.0 && fit.covariance_px2.allFinite();
  return determined ? std::optional<CircleFit>(fit) : std::nullopt;
}

}  // namespace bearing_calibration::core
