#include "bearing_calibration/vision/optics_learner.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/vision/light_detector.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Places of the unknowns. Logarithms, but for what has a unit.
enum LearntUnknown : int {
  kLogFocalLength,
  kLogAperture,
  kLogFocus,
  kHalfAngle_rad,
  kLightHeight_m,  ///< over the apex
  kLightWidth_m,   ///< standard deviations of the light's surface, sideways and upwards
  kLightTallness_m,
  kHarmonicCos_px,  ///< of the image radius over the azimuth: tilt, offset and centre
  kHarmonicSin_px,
  kTangentialMeasure,  ///< what threshold, clipping and lens do to all measured sizes alike
  kRadialMeasure,
};

constexpr double kLearnt = 0.5;  // of the prior's standard deviation
constexpr double kHeightStddev_m = 0.2;
constexpr double kMeasureStddev = 0.05;
// Of one image.
constexpr double kRadiusStddev_px = 1.0;
constexpr double kSizeStddev = 0.06;
constexpr double kApart_s = 0.5;
constexpr double kGate = 16.3;  // 0.999 of chi-square, 3 degrees of freedom
constexpr double kLens_px = 0.25;

}  // namespace

const char* nameOf(OpticsState state) {
  static constexpr std::array<const char*, 3> kNames{"configured", "learning", "learnt"};
  return kNames.at(static_cast<std::size_t>(state));
}

OpticsLearner::OpticsLearner(const DetectorConfig& configured)
    : configured_(validated(configured)) {
  if (configured.mirror_kind != MirrorKind::kCone) {
    throw std::invalid_argument("only the optics of a conic mirror can be learnt");
  }
  const OpticsUncertainty& stddev = configured.optics_stddev;
  prior_stddev_.head<kValues>() << stddev.scale, stddev.aperture, stddev.focus,
      stddev.half_angle_rad;
  prior_stddev_(kLightHeight_m) = kHeightStddev_m;
  const auto assumeEvenly = [&](int unknown, double least_m, double most_m) {
    prior_mean_(unknown) = 0.5 * kRingStddev * (least_m + most_m);
    prior_stddev_(unknown) = kRingStddev * (most_m - least_m) / std::sqrt(12.0);
  };
  const LightModel& light = configured.light;
  assumeEvenly(kLightWidth_m, light.min_radius_m, light.radius_m);
  assumeEvenly(kLightTallness_m, 0.0, light.half_height_m);
  // A lean bends azimuths by 2 cot(tau) lean (O6), and elevations by twice the lean.
  const ConicMirror& mirror = configured.mirror;
  const double tilt_rad =
      std::tan(mirror.half_angle_rad) * configured.alignment.geometry.harmonic_stddev_rad;
  const double px_per_rad = 1.0 / elevationSlope(mirror, horizonRadiusPx(mirror));
  prior_stddev_.segment<2>(kHarmonicCos_px).setConstant(1.0 + tilt_rad * px_per_rad);
  prior_stddev_.segment<2>(kTangentialMeasure).setConstant(kMeasureStddev);
}

ConicMirror OpticsLearner::mirrorAt(const Vector& state) const {
  constexpr double kNearestFocus = 1.01;    // no lens is focused nearer than its focal length
  constexpr double kFarthestFocus_m = 1e6;  // infinity
  const Vector off = prior_mean_ + prior_stddev_.cwiseProduct(state);
  ConicMirror mirror = configured_.mirror;
  mirror.focal_length_m *= std::exp(off(kLogFocalLength));
  mirror.aperture_m *= std::exp(off(kLogAperture));
  mirror.focus_distance_m = std::clamp(mirror.focus_distance_m * std::exp(off(kLogFocus)),
                                       kNearestFocus * mirror.focal_length_m, kFarthestFocus_m);
  mirror.half_angle_rad += off(kHalfAngle_rad);
  return mirror;
}

/// Image radius [px] and the logarithms of the spot's standard deviations (tangential, radial).
std::optional<Vector3d> OpticsLearner::expected(const Vector& state, const RangedSpot& spot) const {
  const Vector off = prior_mean_ + prior_stddev_.cwiseProduct(state);
  const ConicMirror mirror = mirrorAt(state);
  const auto radius_px = radiusFromLight(mirror, {spot.distance_m, off(kLightHeight_m)});
  const double seen_px = spot.image_radius_px;  // where it stands, whatever the tilt
  if (!radius_px || spot.distance_m < configured_.light.min_distance_m ||
      !showsOutside(mirror, seen_px, spot.distance_m)) {
    return std::nullopt;
  }
  const SpotVariances light =
      spotVariances(mirror, seen_px, spot.distance_m, off(kLightWidth_m), off(kLightTallness_m));
  const double common_px2 =
      kPixelVariance + std::pow(configured_.defocus_sigma_px, 2) + kLens_px * kLens_px;
  const Eigen::Array2d log_stddevs = 0.5 * (light.open_px2 + light.own_px2 + common_px2).log();
  return Vector3d(*radius_px + off(kHarmonicCos_px) * std::cos(spot.azimuth_rad) +
                      off(kHarmonicSin_px) * std::sin(spot.azimuth_rad),
                  log_stddevs(0) + off(kTangentialMeasure), log_stddevs(1) + off(kRadialMeasure));
}

bool OpticsLearner::add(const RangedSpot& spot) {
  if (isSoon(spot.stamp)) return false;
  if (!update(spot)) {
    countUnlike(spot.stamp);
    return false;
  }
  last_ = spot.stamp;
  ++used_;
  unlike_ = 0;
  return true;
}

void OpticsLearner::miss(Stamp stamp) {
  if (!isSoon(stamp)) countUnlike(stamp);
}

void OpticsLearner::see(const std::vector<Detection>& lights, const BearingSet& bearings,
                        const BearingPrediction& prediction) {
  if (!isOfMoment(prediction, bearings.stamp)) return;
  const Detection* light = likeliestLight(lights);
  if (const auto spot = rangedSpot(lights, bearings, prediction)) {
    add(*spot);
  } else if (light == nullptr || light->bearing.probability < LightDetector::kLikely) {
    miss(bearings.stamp);
  }
}

/// What is wrong with an image is wrong with the next one, too.
bool OpticsLearner::isSoon(Stamp stamp) const {
  return last_ && std::abs(secondsFromDuration(stamp - *last_)) < kApart_s;
}

void OpticsLearner::countUnlike(Stamp stamp) {
  constexpr int kMostUnlike = 20;
  last_ = stamp;
  if (++unlike_ < kMostUnlike) return;
  mean_.setZero();
  covariance_.setIdentity();
  used_ = unlike_ = 0;
}

/// Iterated Kalman update. @returns false where the spot is left out
bool OpticsLearner::update(const RangedSpot& spot) {
  const Eigen::Vector2d logs = 0.5 * spot.variances_px2.cwiseMax(kPixelVariance).array().log();
  const Vector3d measured(spot.image_radius_px, logs(0), logs(1));
  constexpr int kIterations = 4;
  constexpr double kStep = 0.01;  // of the prior's standard deviations
  using Jacobian = Eigen::Matrix<double, 3, kUnknowns>;
  Vector state = mean_;
  Jacobian H;
  Eigen::Matrix<double, kUnknowns, 3> gain;
  Matrix3d noise;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const auto here = expected(state, spot);
    if (!here) return false;
    for (int i = 0; i < kUnknowns; ++i) {
      const auto beside = expected(state + kStep * Vector::Unit(i), spot);
      if (!beside) return false;
      H.col(i) = (*beside - *here) / kStep;
    }
    RangedSpot farther = spot;
    farther.distance_m += std::sqrt(spot.distance_variance_m2);
    const auto there = expected(state, farther);
    if (!there) return false;
    const Vector3d by_distance = *there - *here;
    noise = by_distance * by_distance.transpose();
    noise.diagonal() += Vector3d(kRadiusStddev_px, kSizeStddev, kSizeStddev).cwiseAbs2();
    const Matrix3d information = (H * covariance_ * H.transpose() + noise).inverse();
    const Vector3d innovation = measured - *here - H * (mean_ - state);
    if (iteration == kIterations - 1 && innovation.dot(information * innovation) > kGate) {
      return false;
    }
    gain = covariance_ * H.transpose() * information;
    state = mean_ + gain * innovation;
  }
  if (!errorsOf(mirrorAt(state)).empty()) return false;
  mean_ = state;
  const Matrix rest = Matrix::Identity() - gain * H;
  covariance_ = rest * covariance_ * rest.transpose() + gain * noise * gain.transpose();
  symmetrise(&covariance_);
  return true;
}

double OpticsLearner::stddevOf(int value) const { return std::sqrt(covariance_(value, value)); }

DetectorConfig OpticsLearner::applied(DetectorConfig config) const {
  config.mirror = mirrorAt(mean_);
  OpticsUncertainty& stddev = config.optics_stddev;
  stddev.scale *= stddevOf(kLogFocalLength);
  stddev.aperture *= stddevOf(kLogAperture);
  stddev.focus *= stddevOf(kLogFocus);
  stddev.half_angle_rad *= stddevOf(kHalfAngle_rad);
  return config;
}

bool OpticsLearner::hasNews() {
  constexpr double kBetter = 0.8;  // times the standard deviation; or worse
  constexpr double kMoved = 0.5;   // standard deviations
  bool news = false;
  for (int i = 0; i < kValues; ++i) {
    if (prior_stddev_(i) == 0.0) continue;
    const double ratio = stddevOf(i) / said_stddev_(i);
    news = news || ratio < kBetter || ratio > 1.0 / kBetter ||
           std::abs(mean_(i) - said_mean_(i)) > kMoved * said_stddev_(i);
  }
  if (!news) return false;
  said_mean_ = mean_;
  said_stddev_ = covariance_.diagonal().cwiseSqrt();
  return true;
}

std::array<LearntOptics, OpticsLearner::kValues> OpticsLearner::optics() const {
  const ConicMirror mirror = mirrorAt(mean_);
  const auto of = [&](int value, const char* parameter, const char* stddev_parameter,
                      double now) -> LearntOptics {
    const bool seen = used_ > 0 && prior_stddev_(value) > 0.0;
    const bool learnt = seen && stddevOf(value) <= kLearnt;
    return {parameter, stddev_parameter, now, prior_stddev_(value) * stddevOf(value),
            learnt ? OpticsState::kLearnt
            : seen ? OpticsState::kLearning
                   : OpticsState::kConfigured};
  };
  return {
      of(kLogFocalLength, "lens/focal_length", "lens/scale_stddev", mirror.focal_length_m),
      of(kLogAperture, "lens/aperture", "lens/aperture_stddev", mirror.aperture_m),
      of(kLogFocus, "lens/focus_distance", "lens/focus_stddev", mirror.focus_distance_m),
      of(kHalfAngle_rad, "mirror/half_angle", "mirror/half_angle_stddev", mirror.half_angle_rad)};
}

int OpticsLearner::learntValues() const {
  const auto all = optics();
  return static_cast<int>(std::count_if(all.begin(), all.end(), [](const LearntOptics& each) {
    return each.state == OpticsState::kLearnt;
  }));
}

int OpticsLearner::learntValuesIn(const std::string& yaml) const {
  const auto known = optics();
  int learnt = 0;
  std::istringstream lines(yaml);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name;
    double stddev = 0.0;
    if (!(words >> name >> stddev)) continue;
    for (int i = 0; i < kValues; ++i) {
      const std::string parameter = known.at(static_cast<std::size_t>(i)).stddev_parameter;
      const bool is_it = name == parameter.substr(parameter.find('/') + 1) + ":";
      if (is_it && stddev > 0.0 && stddev <= kLearnt * prior_stddev_(i)) ++learnt;
    }
  }
  return learnt;
}

std::string yamlOf(const OpticsLearner& learner) {
  std::string text =
      "# Lens and mirror as the images of a light have shown them (detection.md, \"Optics learnt\n"
      "# while driving\"): parameters of the light detection, for its overrides.\n";
  std::string group;
  const auto add = [&](const std::string& parameter, double value) {
    const std::size_t slash = parameter.find('/');
    if (parameter.substr(0, slash) != group) {
      group = parameter.substr(0, slash);
      text += group + ":\n";
    }
    text += formatted("  %s: %.9f\n", parameter.substr(slash + 1).c_str(), value);
  };
  for (const LearntOptics& each : learner.optics()) {
    add(each.parameter, each.value);
    add(each.stddev_parameter, each.stddev);
  }
  return text;
}

}  // namespace bearing_calibration::core
