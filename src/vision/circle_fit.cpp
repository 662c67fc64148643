#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/mirror_rim.h"

namespace bearing_calibration::core {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLeastScatter_px = 1e-3;  // keeps the weights finite on perfect points

/// The points' distances from a circle, how much they count, and what makes a step and its
/// covariance of that. Rows are points, parameters are (centre u, centre v, radius).
struct Residuals {
  Residuals(const std::vector<Vector2d>& points_px, const Circle& circle);

  Matrix3d information(const ArrayXd& by) const {
    return gradients.transpose() * by.matrix().asDiagonal() * gradients;
  }
  Matrix3d covariance() const;

  ArrayXd values_px;
  Eigen::MatrixX3d gradients;
  double scatter_px;  ///< robust
  ArrayXd weights;    ///< Tukey's, 0 for a stranger
  ArrayXd slopes;     ///< derivatives of weight * value
};

double robustScatter(const ArrayXd& values) {
  constexpr double kSigmaOfMad = 1.4826;  // of a Gaussian: sigma over the median of the sizes
  ArrayXd sizes = values.abs();
  double* middle = sizes.data() + sizes.size() / 2;
  std::nth_element(sizes.data(), middle, sizes.data() + sizes.size());
  return std::max(kLeastScatter_px, kSigmaOfMad * *middle);
}

Residuals::Residuals(const std::vector<Vector2d>& points_px, const Circle& circle)
    : values_px(points_px.size()), gradients(points_px.size(), 3) {
  for (Index i = 0; i < values_px.size(); ++i) {
    const Vector2d from_centre = points_px[static_cast<std::size_t>(i)] - circle.centre_px;
    const double distance_px = std::max(from_centre.norm(), kLeastScatter_px);
    values_px(i) = distance_px - circle.radius_px;
    gradients.row(i) << -from_centre.transpose() / distance_px, -1.0;
  }
  scatter_px = robustScatter(values_px);
  constexpr double kTukey = 4.685;  // 95 % of least squares' efficiency on Gaussian errors
  const ArrayXd rest = (1.0 - (values_px / (kTukey * scatter_px)).square()).max(0.0);
  weights = rest.square();
  slopes = rest * (5.0 * rest - 4.0);
}

/// Of an estimate from groups of neighbours that may err together (cluster-robust "sandwich").
Matrix3d Residuals::covariance() const {
  constexpr int kGroups = 36;
  Eigen::Matrix<double, 3, kGroups> groups = Eigen::Matrix<double, 3, kGroups>::Zero();
  for (Index i = 0; i < values_px.size(); ++i) {
    const double turn = 0.5 + std::atan2(-gradients(i, 1), -gradients(i, 0)) / (2.0 * kPi);
    const int group = std::min(kGroups - 1, static_cast<int>(turn * kGroups));
    groups.col(group) += weights(i) * values_px(i) * gradients.row(i).transpose();
  }
  const Index used = (groups.colwise().squaredNorm().array() > 0.0).count();
  const Index free = std::max<Index>(1, used - groups.rows());
  const Matrix3d bread = information(slopes).inverse();
  return static_cast<double>(used) / static_cast<double>(free) * bread * groups *
         groups.transpose() * bread;
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

double CircleFit::stddev(int parameter) const {
  return std::sqrt(covariance_px2(parameter, parameter));
}

std::optional<CircleFit> fitCircle(const std::vector<Vector2d>& points_px, const Circle& start) {
  constexpr int kMostSteps = 50;
  constexpr double kSettled_px = 1e-6;
  constexpr double kLeastInformation = 1e-6;  // an arc of a few degrees has less
  if (points_px.size() <= 3) return std::nullopt;
  CircleFit fit;
  fit.circle = start;
  for (int i = 0; i < kMostSteps; ++i) {  // reweighted Gauss-Newton steps
    const Residuals residuals(points_px, fit.circle);
    const Matrix3d normal = residuals.information(residuals.weights);
    if (!(std::abs(normal.determinant()) > kLeastInformation)) return std::nullopt;
    const Vector3d right =
        residuals.gradients.transpose() * (residuals.weights * residuals.values_px).matrix();
    const Vector3d step = -normal.inverse() * right;
    fit.circle.centre_px += step.head<2>();
    fit.circle.radius_px += step.z();
    if (step.norm() < kSettled_px) break;
  }
  const Residuals residuals(points_px, fit.circle);
  fit.covariance_px2 = residuals.covariance();
  fit.scatter_px = residuals.scatter_px;
  for (std::size_t i = 0; i < points_px.size(); ++i) {
    if (residuals.weights(static_cast<Index>(i)) > 0.0) fit.points_px.push_back(points_px[i]);
  }
  const bool determined = fit.circle.radius_px > 0.0 && fit.covariance_px2.allFinite();
  return determined ? std::optional<CircleFit>(fit) : std::nullopt;
}

}  // namespace bearing_calibration::core
