#include "bearing_calibration/optics/camera.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMostSteps = 50;  // Newton's: five in the middle, some more where a lens ends
constexpr double kExact = 1e-10;

/// By which a lens lengthens q, the tangent or the angle between a ray and its axis.
struct Lengthening {
  double factor = 1.0;
  double by_square = 0.0;  ///< d factor / d q^2

  /// d (q factor) / d q
  double slope(double square) const { return factor + 2.0 * square * by_square; }
};

Lengthening lengtheningAt(const Camera& camera, double square) {
  const std::array<double, 8>& d = camera.distortion;
  const auto cubic = [square](double a, double b, double c) {
    return 1.0 + square * (a + square * (b + square * c));
  };
  const auto cubic_slope = [square](double a, double b, double c) {
    return a + square * (2.0 * b + square * 3.0 * c);
  };
  if (camera.lens == Lens::kFisheye) {
    const double square3 = square * square * square;
    return {cubic(d[0], d[1], d[2]) + d[3] * square3 * square,
            cubic_slope(d[0], d[1], d[2]) + 4.0 * d[3] * square3};
  }
  const double above = cubic(d[0], d[1], d[4]);
  const double below = cubic(d[5], d[6], d[7]);
  const double above_slope = cubic_slope(d[0], d[1], d[4]);
  const double below_slope = cubic_slope(d[5], d[6], d[7]);
  return {above / below, (above_slope * below - above * below_slope) / (below * below)};
}

/// Whether the lens' image goes outwards all the way to q: else another ray has the same one.
bool growsUpTo(const Camera& camera, double q) {
  constexpr int kSamples = 32;
  for (int i = 1; i <= kSamples; ++i) {
    const double square = std::pow(q * i / kSamples, 2);
    if (!(lengtheningAt(camera, square).slope(square) > 0.0)) return false;
  }
  return true;
}

/// The perspective image (a, b) of (x, y) over z, and its Jacobian.
struct BentPoint {
  Vector2d bent;
  Matrix2d J_bent_straight;
};

BentPoint bend(const Camera& camera, const Vector2d& straight) {
  const double p1 = camera.distortion[2];
  const double p2 = camera.distortion[3];
  const double square = straight.squaredNorm();
  const Lengthening lengthening = lengtheningAt(camera, square);
  const double x = straight.x();
  const double y = straight.y();
  const Vector2d decentred(2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
                           p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y);
  Matrix2d J_decentred;
  J_decentred << 2.0 * p1 * y + 6.0 * p2 * x, 2.0 * p1 * x + 2.0 * p2 * y,
      2.0 * p1 * x + 2.0 * p2 * y, 6.0 * p1 * y + 2.0 * p2 * x;
  return {lengthening.factor * straight + decentred,
          lengthening.factor * Matrix2d::Identity() +
              2.0 * lengthening.by_square * straight * straight.transpose() + J_decentred};
}

std::optional<Vector3d> perspectiveRay(const Camera& camera, const Vector2d& bent) {
  Vector2d straight = bent;
  for (int step = 0; step < kMostSteps; ++step) {
    const BentPoint point = bend(camera, straight);
    const Vector2d off = bent - point.bent;
    if (!(point.J_bent_straight.determinant() > 0.0)) return std::nullopt;
    if (off.norm() < kExact) {
      if (!growsUpTo(camera, straight.norm())) return std::nullopt;
      return straight.homogeneous().normalized();
    }
    straight += point.J_bent_straight.inverse() * off;
  }
  return std::nullopt;
}

std::optional<Vector3d> fisheyeRay(const Camera& camera, const Vector2d& bent) {
  const double length = bent.norm();
  if (length < kExact) return Vector3d::UnitZ();
  double angle = std::min(length, kPi);
  for (int step = 0; step < kMostSteps; ++step) {
    const double square = angle * angle;
    const Lengthening lengthening = lengtheningAt(camera, square);
    const double off = length - angle * lengthening.factor;
    const double slope = lengthening.slope(square);
    if (!(slope > 0.0)) return std::nullopt;
    if (std::abs(off) < kExact) {
      if (!(angle <= kPi && growsUpTo(camera, angle))) return std::nullopt;
      const Vector2d across = std::sin(angle) / length * bent;
      return Vector3d(across.x(), across.y(), std::cos(angle));
    }
    angle += off / slope;
  }
  return std::nullopt;
}

bool isShown(const Camera& camera, int width_px, int height_px, double azimuth_rad,
             double elevation_rad) {
  const Vector3d ray(std::cos(elevation_rad) * std::cos(azimuth_rad),
                     std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad));
  const std::optional<Vector2d> pixel =
      pixelFromRay(camera, camera.sensor_from_optical.transpose() * ray);
  return pixel && pixel->minCoeff() >= 0.0 && pixel->x() <= width_px - 1.0 &&
         pixel->y() <= height_px - 1.0;
}

/// The longest range of azimuths that an image shows; of no width where it shows all of them. None
/// where it shows less than two.
std::optional<FieldOfView> viewAt(const Camera& camera, int width_px, int height_px,
                                  double elevation_rad) {
  constexpr int kAzimuths = 720;
  constexpr double kStep_rad = 2.0 * kPi / kAzimuths;
  int run = 0;
  int longest = 0;
  int end_of_longest = 0;
  for (int i = 0; i < 2 * kAzimuths && longest < kAzimuths;
       ++i) {  // a range may go on after a turn
    run = isShown(camera, width_px, height_px, i * kStep_rad, elevation_rad) ? run + 1 : 0;
    if (run <= longest) continue;
    longest = run;
    end_of_longest = i;
  }
  if (longest < 2) return std::nullopt;
  if (longest == kAzimuths) return FieldOfView();
  const double view_rad = (longest - 1) * kStep_rad;
  return FieldOfView{wrapAngle(end_of_longest * kStep_rad - 0.5 * view_rad), view_rad};
}

}  // namespace

bool Camera::operator==(const Camera& other) const {
  return focal_u_px == other.focal_u_px && focal_v_px == other.focal_v_px &&
         centre_u_px == other.centre_u_px && centre_v_px == other.centre_v_px &&
         lens == other.lens && distortion == other.distortion &&
         sensor_from_optical == other.sensor_from_optical;
}

std::string whyNoCamera(const Camera& camera) {
  const auto isFinite = [](double value) { return std::isfinite(value); };
  if (!(camera.focal_u_px > 0.0 && camera.focal_v_px > 0.0 && isFinite(camera.focal_u_px) &&
        isFinite(camera.focal_v_px))) {
    return "its focal lengths K[0] and K[4] must be greater than 0: is the camera calibrated?";
  }
  if (!isFinite(camera.centre_u_px) || !isFinite(camera.centre_v_px)) {
    return "its centre K[2], K[5] is not finite";
  }
  const bool all_finite = std::all_of(camera.distortion.begin(), camera.distortion.end(), isFinite);
  return all_finite ? "" : "a coefficient D of its distortion is not finite";
}

std::optional<Vector2d> pixelFromRay(const Camera& camera, const Vector3d& ray) {
  Vector2d bent;
  if (camera.lens == Lens::kFisheye) {
    const double across = ray.head<2>().norm();
    const double angle = std::atan2(across, ray.z());
    const bool has_place = across > 0.0 || ray.z() > 0.0;  // behind the lens it is a circle
    if (!has_place || !growsUpTo(camera, angle)) return std::nullopt;
    const double length = angle * lengtheningAt(camera, angle * angle).factor;
    bent = across > 0.0 ? Vector2d(length / across * ray.head<2>()) : Vector2d::Zero();
  } else {
    if (!(ray.z() > 0.0)) return std::nullopt;
    const Vector2d straight = ray.hnormalized();
    if (!growsUpTo(camera, straight.norm())) return std::nullopt;
    bent = bend(camera, straight).bent;
  }
  return Vector2d(camera.focal_u_px * bent.x() + camera.centre_u_px,
                  camera.focal_v_px * bent.y() + camera.centre_v_px);
}

std::optional<Vector3d> rayFromPixel(const Camera& camera, const Vector2d& pixel) {
  const Vector2d bent((pixel.x() - camera.centre_u_px) / camera.focal_u_px,
                      (pixel.y() - camera.centre_v_px) / camera.focal_v_px);
  return camera.lens == Lens::kFisheye ? fisheyeRay(camera, bent) : perspectiveRay(camera, bent);
}

FieldOfView viewOf(const Camera& camera, int width_px, int height_px) {
  for (const double elevation_rad : {0.0, 0.1, -0.1, 0.2, -0.2, 0.3, -0.3}) {
    if (const auto view = viewAt(camera, width_px, height_px, elevation_rad)) return *view;
  }
  return {};
}

std::optional<Direction> directionFromPixel(const Camera& camera, const Vector2d& pixel) {
  constexpr double kHalfStep_px = 0.5;  // what a light's centre is certain to is less
  const auto anglesAt = [&](const Vector2d& place_px) -> std::optional<Vector2d> {
    const std::optional<Vector3d> ray = rayFromPixel(camera, place_px);
    if (!ray) return std::nullopt;
    const Vector3d v = camera.sensor_from_optical * *ray;
    return Vector2d(std::atan2(v.y(), v.x()), std::atan2(v.z(), v.head<2>().norm()));
  };
  const std::optional<Vector2d> angles = anglesAt(pixel);
  if (!angles) return std::nullopt;
  Direction direction{angles->x(), angles->y()};
  for (int axis : {0, 1}) {
    const Vector2d step = kHalfStep_px * Vector2d::Unit(axis);
    const std::optional<Vector2d> more = anglesAt(pixel + step);
    const std::optional<Vector2d> less = anglesAt(pixel - step);
    if (!more || !less) return std::nullopt;
    const Vector2d change(wrapAngle(more->x() - less->x()), more->y() - less->y());
    direction.J_direction_pixel.col(axis) = change / (2.0 * kHalfStep_px);
  }
  return direction;
}

}  // namespace bearing_calibration::core
