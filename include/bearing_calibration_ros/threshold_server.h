#pragma once

#include <bearing_calibration/DetectionThresholdsConfig.h>
#include <dynamic_reconfigure/server.h>
#include <ros/node_handle.h>

#include <cstdint>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>

#include "bearing_calibration/common/parameter_bounds.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {

/// The detector's thresholds by dynamic_reconfigure, below ~thresholds, with their bounds. What the
/// detector cannot work with is refused: the thresholds before it stay, and `refusal` tells why.
class ThresholdServer {
 public:
  /// Takes the changed thresholds over; they have been validated.
  using Apply = std::function<void(const core::DetectorConfig&)>;
  /// Is told of each change, or of its refusal.
  using Say = std::function<void(bool is_taken, const std::string& sentence)>;

  /// @param detector  what the thresholds are when it begins, and all that they belong to
  ThresholdServer(const ros::NodeHandle& private_node_handle, const core::DetectorConfig& detector,
                  Apply apply, Say say)
      : detector_(detector),
        apply_(std::move(apply)),
        say_(std::move(say)),
        server_(ros::NodeHandle(private_node_handle, "thresholds")) {
    server_.setConfigDefault(current());
    const core::Bounds bounds(detector_);
    server_.setConfigMin(
        bound(Config::__getMin__(), [&](auto name) { return bounds.ranges().at(name).least; }));
    server_.setConfigMax(
        bound(Config::__getMax__(), [&](auto name) { return bounds.ranges().at(name).most; }));
    server_.setCallback([this](Config& changed, std::uint32_t) { onChange(changed); });
  }

 private:
  using Config = msg::DetectionThresholdsConfig;

  /// Takes each threshold to `pair`: its parameter's name, and its places in both configurations.
  template <typename Pair>
  static void forEachThreshold(core::DetectorConfig& detector, Config& config, Pair pair) {
    pair("threshold/min_contrast", detector.threshold.min_contrast_levels, config.min_contrast);
    pair("threshold/spreads", detector.threshold.spreads, config.spreads);
    pair("gates/min_pixels", detector.gates.min_pixels, config.min_pixels);
    pair("gates/max_pixels", detector.gates.max_pixels, config.max_pixels);
    pair("gates/min_probability", detector.gates.min_probability, config.min_probability);
  }

  Config current() {
    Config config = Config::__getDefault__();
    forEachThreshold(detector_, config, [](auto, auto ours, auto& theirs) { theirs = ours; });
    return config;
  }

  /// @param limits  what `of` replaces by the thresholds' bounds
  template <typename Of>
  Config bound(Config limits, Of of) {
    forEachThreshold(detector_, limits, [&](auto name, auto, auto& theirs) {
      theirs = static_cast<std::decay_t<decltype(theirs)>>(of(name));
    });
    return limits;
  }

  void onChange(Config& config) {
    std::string refusal;
    if (std::exchange(has_begun_, true)) {  // what an earlier run left on the server gives way
      refusal = thrownBy([&] {
        core::DetectorConfig changed = detector_;
        forEachThreshold(changed, config, [](auto, auto& ours, auto theirs) { ours = theirs; });
        detector_ = core::validated(changed);
        apply_(detector_);
      });
      say_(refusal.empty(), refusal.empty() ? "the thresholds have changed"
                                            : "thresholds refused, those before stay: " + refusal);
    }
    config = current();
    config.refusal = refusal;
  }

  core::DetectorConfig detector_;
  Apply apply_;
  Say say_;
  bool has_begun_ = false;
  dynamic_reconfigure::Server<Config> server_;
};

}  // namespace bearing_calibration_ros
