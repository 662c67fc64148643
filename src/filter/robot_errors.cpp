#include "bearing_calibration/filter/robot_errors.h"

#include <algorithm>
#include <stdexcept>

namespace bearing_calibration::core {

void ErrorPriors::setBlock(const std::string& name, double block_stddev) {
  bool found = false;
  forEachBlock([&](auto block, auto at) {
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
  light_height_m = mean_m;
  light_height_stddev_m = stddev_m;
  if (!usesElevations()) return;
  mean.segment<kMostLights>(heightAt(0)).setConstant(mean_m);
  stddev.segment<kMostLights>(heightAt(0)).setConstant(stddev_m);
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

StateEstimate withNearness(StateEstimate estimate, double nearness_stddev_m) {
  estimate.covariance.diagonal().head<2>().array() += nearness_stddev_m * nearness_stddev_m;
  return estimate;
}

StateEstimate withoutNearness(StateEstimate estimate, double nearness_stddev_m) {
  estimate.covariance.diagonal().head<2>().array() -= nearness_stddev_m * nearness_stddev_m;
  return estimate;
}

void ErrorPriors::declare(Parameters& params) {
  constexpr double kLargest = 10.0;  // s, rad, rad m or a ratio
  constexpr double kLargestHeight_m = 100.0;
  forEachBlock([&](auto block, auto at) {
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
  ErrorEstimate known{priors.mean, priors.stddev.cwiseAbs2().asDiagonal()};
  constexpr int kOthers = kErrorCount - heightAt(1);
  known.mean.tail<kOthers>().setZero();
  known.covariance.diagonal().tail<kOthers>().setZero();
  return known;
}

int errorsInUse(const ErrorPriors& priors, int lights) {
  if (priors.usesElevations()) return heightAt(lights);
  int in_use = 0;
  forEachBlock([&](auto block, auto at) {
    if ((partOf(priors.stddev, block, at).array() > 0.0).any()) {
      in_use = at.value + decltype(block)::kSize;
    }
  });
  return in_use;
}

bool lasts(int error) {
  bool lasts = false;
  forEachBlock([&](auto block, auto at) {
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
    forEachBlock([&](auto block, auto) {
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
    forEachBlock([&](auto block, auto at) {
      using Block = decltype(block);
      blocks.push_back({Block::kName, at.value, Block::kSize, Block::kWhenHeld});
    });
    return blocks;
  }();
  return kBlocks;
}

}  // namespace bearing_calibration::core
