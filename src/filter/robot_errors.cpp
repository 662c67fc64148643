#include "bearing_calibration/filter/robot_errors.h"

#include <cmath>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/bearing_model.h"

namespace bearing_calibration::core {
namespace {

/// Calls work(block, place) for each block whose errors are among the first K.
template <int K, class Work, std::size_t I = 0, int At = 0>
void forEachBlock(const Work& work) {
  if constexpr (At < K) {
    using Block = std::tuple_element_t<I, ErrorBlocks>;
    static_assert(At + Block::kSize <= K, "a block is carried whole or not at all");
    work(Block(), std::integral_constant<int, At>());
    if constexpr (I + 1 < std::tuple_size_v<ErrorBlocks>) {
      forEachBlock<K, Work, I + 1, At + Block::kSize>(work);
    }
  }
}

/// The same from the last of them to the first.
template <int K, class Work, std::size_t I = 0, int At = 0>
void forEachBlockBackwards(const Work& work) {
  if constexpr (At < K) {
    using Block = std::tuple_element_t<I, ErrorBlocks>;
    if constexpr (I + 1 < std::tuple_size_v<ErrorBlocks>) {
      forEachBlockBackwards<K, Work, I + 1, At + Block::kSize>(work);
    }
    work(Block(), std::integral_constant<int, At>());
  }
}

template <class Block, int At>
auto partOf(const ErrorVector& errors, Block, std::integral_constant<int, At>) {
  return errors.segment<Block::kSize>(At);
}

WheelFactors wheelFactors(const ErrorVector& errors) {
  WheelFactors wheels;
  forEachBlock<kErrorCount>(
      [&](auto block, auto at) { decltype(block)::addTo(wheels, partOf(errors, block, at)); });
  return wheels;
}

template <int K>
CorrectedLight<K> correctLight(const Eigen::Vector2d& light_in_base, const ErrorVector& errors,
                               const OdometryWindow& nearby) {
  CorrectedLight<K> light;
  light.in_base = light_in_base;
  const WheelFactors wheels = wheelFactors(errors);
  forEachBlock<K>([&](auto block, auto at) {
    decltype(block)::template correct<at.value>(light, nearby, wheels, partOf(errors, block, at));
  });
  return light;
}

/// Jacobian by the Cartesian state of an angle that depends on the ideal azimuth and on the range.
Eigen::Matrix<double, 1, 5> stateJacobian(double J_angle_ideal, double J_angle_range,
                                          const AzimuthModel& ideal, const Eigen::Vector2d& ray) {
  const Eigen::RowVector2d J_range = ray.transpose() / ray.norm();
  Eigen::Matrix<double, 1, 5> J = J_angle_ideal * ideal.J_azimuth_state;
  J.head<2>() += J_angle_range * J_range;
  J.segment<2>(CartesianIndex::kSensorX) -= J_angle_range * J_range;
  return J;
}

}  // namespace

void ErrorPriors::setBlock(const std::string& name, double block_stddev) {
  bool found = false;
  forEachBlock<kErrorCount>([&](auto block, auto at) {
    using Block = decltype(block);
    if (name != Block::kName) return;
    found = true;
    for (std::size_t i = 0; i < Block::kPriorWeights.size(); ++i) {
      stddev(at.value + static_cast<int>(i)) = Block::kPriorWeights[i] * block_stddev;
    }
  });
  if (!found) throw std::invalid_argument("no error of the robot is called " + name);
}

void ErrorPriors::setLightHeight(double mean_m, double stddev_m) {
  constexpr int kHeight = placeOf<SensorTilt>() + SensorTilt::kHeight;
  light_height_m = mean_m;
  light_height_stddev_m = stddev_m;
  if (!usesElevations()) return;
  mean(kHeight) = mean_m;
  stddev(kHeight) = stddev_m;
}

void ErrorPriors::setGeometry(const SensorGeometry& geometry) {
  setBlock(MirrorHarmonic::kName, geometry.harmonic_stddev_rad);
  nearness_stddev_m = geometry.nearness_stddev_rad_m;
  mean(placeOf<MirrorHarmonic>() + MirrorHarmonic::kNearPerFar) =
      geometry.harmonic_stddev_rad > 0.0 ? geometry.near_per_far_m : 0.0;
}

SensorGeometry ErrorPriors::geometry() const {
  constexpr int kHarmonic = placeOf<MirrorHarmonic>();
  return {stddev(kHarmonic), mean(kHarmonic + MirrorHarmonic::kNearPerFar), nearness_stddev_m};
}

CartesianEstimate withNearness(CartesianEstimate estimate, double nearness_stddev_m) {
  estimate.covariance.diagonal().segment<2>(CartesianIndex::kSensorX).array() +=
      nearness_stddev_m * nearness_stddev_m;
  return estimate;
}

void ErrorPriors::declare(Parameters& params) {
  constexpr double kLargest = 10.0;  // s, rad, rad m or a ratio
  constexpr double kLargestHeight_m = 100.0;
  forEachBlock<kErrorCount>([&](auto block, auto at) {
    using Block = decltype(block);
    const std::string name = std::string("errors/") + Block::kName + "_stddev";
    double block_stddev = 0.0;
    if (!Block::kSaidBySensor && params.read(name, block_stddev)) {
      setBlock(Block::kName, block_stddev);
    }
    const auto part = partOf(stddev, block, at);
    for (int i = 0; i < part.size(); ++i) {
      const double weight = Block::kPriorWeights[static_cast<std::size_t>(i)];
      params.between(name, part(i), 0.0, std::max(weight, 1.0) * kLargest);
    }
  });
  if (params.read("errors/light_height", light_height_m) &&
      params.read("errors/light_height_stddev", light_height_stddev_m)) {
    setLightHeight(light_height_m, light_height_stddev_m);
  }
  params.between("errors/light_height", light_height_m, -kLargestHeight_m, kLargestHeight_m);
  params.between("errors/light_height_stddev", light_height_stddev_m, 0.0, kLargestHeight_m);
  params.that(mean.allFinite(), "the errors' means must be finite");
  const auto tilt = stddev.segment<SensorTilt::kSize>(placeOf<SensorTilt>());
  params.that(
      !usesElevations() || tilt.minCoeff() > 0.0,
      "errors/light_height_stddev must be greater than 0 where errors/sensor_tilt_stddev is");
}

ErrorEstimate priorEstimate(const ErrorPriors& priors) {
  ErrorEstimate estimate;
  estimate.mean = priors.mean;
  estimate.covariance.diagonal() = priors.stddev.cwiseAbs2();
  return estimate;
}

template <int K>
CorrectedMotion<K> correctMotion(const OdometryIncrement& measured, const ErrorVector& errors) {
  CorrectedMotion<K> motion;
  motion.start_from_end = measured.start_from_end;
  forEachBlock<K>([&](auto block, auto at) {
    decltype(block)::template correct<at.value>(motion, measured, partOf(errors, block, at));
  });
  return motion;
}

template <int K>
ObservationModel<K> expectObservation(const Vector5& state, const ErrorVector& errors,
                                      const OdometryWindow& nearby) {
  Vector5 at_moment = state;
  CorrectedLight<K> light;
  if constexpr (K > 0) {
    light = correctLight<K>(state.head<2>(), errors, nearby);
    at_moment.head<2>() = light.in_base;
  }
  const AzimuthModel ideal = azimuthFromCartesian(at_moment);
  ObservationModel<K> model;
  if constexpr (K == 0) {
    model.azimuth_rad = ideal.azimuth_rad;
    model.J_azimuth_state = ideal.J_azimuth_state;
  } else {
    const Eigen::Vector2d ray = light.in_base - at_moment.segment<2>(CartesianIndex::kSensorX);
    CorrectedAzimuth<K> azimuth;
    azimuth.azimuth_rad = ideal.azimuth_rad;
    azimuth.range_m = ray.norm();
    forEachBlockBackwards<K>([&](auto block, auto at) {
      decltype(block)::template correct<at.value>(azimuth, partOf(errors, block, at));
    });
    const Eigen::Matrix<double, 1, 5> J =
        stateJacobian(azimuth.J_azimuth_ideal, azimuth.J_azimuth_range, ideal, ray);
    model.azimuth_rad = wrapAngle(azimuth.azimuth_rad);
    model.J_azimuth_state << J.head<2>() * light.J_light_light, J.tail<3>(),
        J.head<2>() * light.J_light_errors + azimuth.J_azimuth_errors;
  }
  return model;
}

ElevationModel expectElevation(const Vector5& state, const ErrorVector& errors,
                               const OdometryWindow& nearby) {
  const auto light = correctLight<kErrorCount>(state.head<2>(), errors, nearby);
  Vector5 at_moment = state;
  at_moment.head<2>() = light.in_base;
  const AzimuthModel ideal = azimuthFromCartesian(at_moment);
  const Eigen::Vector2d ray = light.in_base - at_moment.segment<2>(CartesianIndex::kSensorX);
  CorrectedElevation<kErrorCount> elevation;
  elevation.azimuth_rad = ideal.azimuth_rad;
  elevation.range_m = ray.norm();
  forEachBlockBackwards<kErrorCount>([&](auto block, auto at) {
    decltype(block)::template correct<at.value>(elevation, partOf(errors, block, at));
  });
  const Eigen::Matrix<double, 1, 5> J =
      stateJacobian(elevation.J_elevation_ideal, elevation.J_elevation_range, ideal, ray);
  ElevationModel model;
  model.elevation_rad = elevation.elevation_rad;
  model.J_elevation_state << J.head<2>() * light.J_light_light, J.tail<3>(),
      J.head<2>() * light.J_light_errors + elevation.J_elevation_errors;
  return model;
}

int errorsInUse(const ErrorPriors& priors) {
  int in_use = 0;
  for (int i = 0; i < kErrorCount; ++i) {
    if (priors.stddev(i) > 0.0) in_use = i + 1;
  }
  return withErrorsInUse(in_use, [](auto size) { return size.value; });
}

bool lasts(int error) {
  bool lasts = false;
  forEachBlock<kErrorCount>([&](auto block, auto at) {
    const int part = error - at.value;
    if (part >= 0 && part < decltype(block)::kSize) {
      lasts = decltype(block)::kLasts.at(static_cast<std::size_t>(part));
    }
  });
  return lasts;
}

const std::vector<Quantity>& errorQuantities() {
  static const std::vector<Quantity> kQuantities = [] {
    std::vector<Quantity> quantities;
    forEachBlock<kErrorCount>([&](auto block, auto) {
      for (const Quantity& number : decltype(block)::kNumbers) quantities.push_back(number);
    });
    return quantities;
  }();
  return kQuantities;
}

std::string labelOf(const Quantity& quantity) {
  const std::string name = quantity.name;
  const std::string unit = quantity.unit;
  return unit == "1" ? name : name + " [" + unit + "]";
}

const std::vector<ErrorBlockInfo>& errorBlocks() {
  static const std::vector<ErrorBlockInfo> kBlocks = [] {
    std::vector<ErrorBlockInfo> blocks;
    forEachBlock<kErrorCount>([&](auto block, auto at) {
      using Block = decltype(block);
      blocks.push_back({Block::kName, at.value, Block::kSize, Block::kWhenHeld});
    });
    return blocks;
  }();
  return kBlocks;
}

double residualOf(const Observation& observation, const Vector5& state, const ErrorVector& errors) {
  const auto expected = [&] {
    if (errors.isZero(0.0)) return azimuthFromCartesian(state).azimuth_rad;
    // What bends bearings takes its time, even where nothing is bent.
    const bool is_straight = errors.tail<kErrorCount - kWheelErrors>().isZero(0.0);
    return is_straight
               ? expectObservation<kWheelErrors>(state, errors, observation.nearby).azimuth_rad
               : expectObservation<kErrorCount>(state, errors, observation.nearby).azimuth_rad;
  };
  return wrapAngle(observation.azimuth_rad - expected());
}

std::optional<double> elevationResidualOf(const Observation& observation, const Vector5& state,
                                          const ErrorVector& errors) {
  if (!observation.elevation) return std::nullopt;
  return observation.elevation->angle_rad -
         expectElevation(state, errors, observation.nearby).elevation_rad;
}

Pose2 stampFromMoment(const Observation& observation, const ErrorVector& errors) {
  // where the base's own origin lies, seen from the moment, is all that it takes
  const auto origin =
      correctLight<kErrorCount>(Eigen::Vector2d::Zero(), errors, observation.nearby);
  const Eigen::Matrix2d& R = origin.J_light_light;
  return Pose2{origin.in_base, std::atan2(R(1, 0), R(0, 0))}.inverse();
}

std::vector<Observation> withoutErrors(const std::vector<Observation>& observations,
                                       const ErrorVector& errors) {
  std::vector<Observation> corrected = observations;
  Pose2 last;
  for (Observation& observation : corrected) {
    const Pose2 stamp_from_moment = stampFromMoment(observation, errors);
    const Pose2 motion = correctMotion<kErrorCount>(observation.motion, errors).start_from_end;
    observation.motion.start_from_end = last.inverse() * motion * stamp_from_moment;
    last = stamp_from_moment;
  }
  return corrected;
}

template CorrectedMotion<0> correctMotion<0>(const OdometryIncrement&, const ErrorVector&);
template CorrectedMotion<4> correctMotion<4>(const OdometryIncrement&, const ErrorVector&);
template CorrectedMotion<kAllButTilt> correctMotion<kAllButTilt>(const OdometryIncrement&,
                                                                 const ErrorVector&);
template CorrectedMotion<kErrorCount> correctMotion<kErrorCount>(const OdometryIncrement&,
                                                                 const ErrorVector&);
template ObservationModel<0> expectObservation<0>(const Vector5&, const ErrorVector&,
                                                  const OdometryWindow&);
template ObservationModel<4> expectObservation<4>(const Vector5&, const ErrorVector&,
                                                  const OdometryWindow&);
template ObservationModel<kAllButTilt> expectObservation<kAllButTilt>(const Vector5&,
                                                                      const ErrorVector&,
                                                                      const OdometryWindow&);
template ObservationModel<kErrorCount> expectObservation<kErrorCount>(const Vector5&,
                                                                      const ErrorVector&,
                                                                      const OdometryWindow&);

}  // namespace bearing_calibration::core
