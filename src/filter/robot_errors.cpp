#include "bearing_calibration/filter/robot_errors.h"

#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/filter/bearing_model.h"

namespace bearing_calibration {
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
                               const TravelNearby& nearby) {
  CorrectedLight<K> light;
  light.in_base = light_in_base;
  const WheelFactors wheels = wheelFactors(errors);
  forEachBlock<K>([&](auto block, auto at) {
    decltype(block)::template correct<at.value>(light, nearby, wheels, partOf(errors, block, at));
  });
  return light;
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

std::vector<std::string> ErrorPriors::validate() const {
  Requirements require;
  forEachBlock<kErrorCount>([&](auto block, auto at) {
    for (double value : partOf(stddev, block, at)) {
      require.notNegative(std::string("errors/") + decltype(block)::kName + "_stddev", value);
    }
  });
  return require.errors();
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
SightModel<K> expectSight(const Vector5& state, const ErrorVector& errors,
                          const TravelNearby& nearby) {
  Vector5 at_moment = state;
  CorrectedLight<K> light;
  if constexpr (K > 0) {
    light = correctLight<K>(state.head<2>(), errors, nearby);
    at_moment.head<2>() = light.in_base;
  }
  const AzimuthModel ideal = azimuthFromCartesian(at_moment);
  SightModel<K> model;
  if constexpr (K == 0) {
    model.azimuth_rad = ideal.azimuth_rad;
    model.J_azimuth_state = ideal.J_azimuth_state;
  } else {
    const Eigen::Vector2d sight = light.in_base - at_moment.segment<2>(CartesianIndex::kSensorX);
    CorrectedAzimuth<K> azimuth;
    azimuth.azimuth_rad = ideal.azimuth_rad;
    azimuth.range_m = sight.norm();
    forEachBlock<K>([&](auto block, auto at) {
      decltype(block)::template correct<at.value>(azimuth, partOf(errors, block, at));
    });
    const Eigen::RowVector2d J_range = sight.transpose() / azimuth.range_m;
    Eigen::Matrix<double, 1, 5> J = azimuth.J_azimuth_ideal * ideal.J_azimuth_state;
    J.head<2>() += azimuth.J_azimuth_range * J_range;
    J.segment<2>(CartesianIndex::kSensorX) -= azimuth.J_azimuth_range * J_range;
    model.azimuth_rad = wrapAngle(azimuth.azimuth_rad);
    model.J_azimuth_state << J.head<2>() * light.J_light_light, J.tail<3>(),
        J.head<2>() * light.J_light_errors + azimuth.J_azimuth_errors;
  }
  return model;
}

int errorsInUse(const ErrorPriors& priors) {
  int in_use = 0;
  for (int i = 0; i < kErrorCount; ++i) {
    if (priors.stddev(i) > 0.0) in_use = i + 1;
  }
  return withErrorsInUse(in_use, [](auto size) { return size.value; });
}

std::vector<std::string> errorNames() {
  std::vector<std::string> names;
  forEachBlock<kErrorCount>([&](auto block, auto) {
    for (const char* part : decltype(block)::kParts) names.emplace_back(part);
  });
  return names;
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

double residualOf(const Sight& sight, const Vector5& state, const ErrorVector& errors) {
  const double expected = errors.isZero(0.0)
                              ? azimuthFromCartesian(state).azimuth_rad
                              : expectSight<kErrorCount>(state, errors, sight.nearby).azimuth_rad;
  return wrapAngle(sight.azimuth_rad - expected);
}

Pose2 stampFromMoment(const Sight& sight, const ErrorVector& errors) {
  // where the base's own origin lies, seen from the moment, is all that it takes
  const auto origin = correctLight<kErrorCount>(Eigen::Vector2d::Zero(), errors, sight.nearby);
  const Eigen::Matrix2d& R = origin.J_light_light;
  return Pose2{origin.in_base, std::atan2(R(1, 0), R(0, 0))}.inverse();
}

std::vector<Sight> withoutErrors(const std::vector<Sight>& sights, const ErrorVector& errors) {
  std::vector<Sight> corrected = sights;
  Pose2 last;
  for (Sight& sight : corrected) {
    const Pose2 stamp_from_moment = stampFromMoment(sight, errors);
    const Pose2 motion = correctMotion<kErrorCount>(sight.motion, errors).start_from_end;
    sight.motion.start_from_end = last.inverse() * motion * stamp_from_moment;
    last = stamp_from_moment;
  }
  return corrected;
}

template CorrectedMotion<0> correctMotion<0>(const OdometryIncrement&, const ErrorVector&);
template CorrectedMotion<4> correctMotion<4>(const OdometryIncrement&, const ErrorVector&);
template CorrectedMotion<kErrorCount> correctMotion<kErrorCount>(const OdometryIncrement&,
                                                                 const ErrorVector&);
template SightModel<0> expectSight<0>(const Vector5&, const ErrorVector&, const TravelNearby&);
template SightModel<4> expectSight<4>(const Vector5&, const ErrorVector&, const TravelNearby&);
template SightModel<kErrorCount> expectSight<kErrorCount>(const Vector5&, const ErrorVector&,
                                                          const TravelNearby&);

}  // namespace bearing_calibration
