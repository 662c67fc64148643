#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/output/offline_report.h"
#include "bearing_calibration/output/result.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/detection_params.h"
#include "tools/owner/bag_topics.h"
#include "tools/owner/estimate_history.h"

namespace bearing_calibration::core {

/// What is the same for all bags.
struct BagSetup {
  bearing_calibration_ros::CalibrationNodeConfig calibration;
  bearing_calibration_ros::DetectionNodeConfig detection;
  BagTopics topics;           ///< as wanted
  std::string camera_errors;  ///< required of `detection` and not given: no images can be searched
};

/// The package's own parameters, with what differs from them.
/// @param assignments  NAME=VALUE, after the files
/// @throws std::runtime_error with every wrong parameter
BagSetup readBagSetup(const std::vector<std::string>& config_files,
                      const std::vector<std::string>& assignments, const BagTopics& topics);

/// One calibration: a bag, and in it one light where the sensor tells lights apart.
struct BagJob {
  std::string bag;
  std::optional<std::int32_t> light_id;  ///< none: the first that is seen
  std::string name;                      ///< for people
};

/// What a drive expected of its way ahead at one moment: standard deviations at the way's end.
struct PlanRow {
  Stamp stamp;
  Eigen::Vector3d stddev;  ///< of x [m], y [m] and yaw [rad]
};

/// Where the time went [s].
struct BagTimes {
  double whole = 0.0;
  double reading = 0.0;  ///< on a thread of its own, while the rest goes on
  double detection = 0.0;
  double estimation = 0.0;  ///< the running calibration and the review
};

/// What one bag told.
struct BagOutcome {
  CalibrationResult result;  ///< of the calibration at its end
  Review review;
  std::vector<EstimateRow> history;
  std::vector<PlanRow> plans;  ///< as they changed
  BagTopics topics;
  std::vector<std::string> warnings;  ///< sentences
  std::uint64_t images = 0;           ///< searched for the light
  std::string optics;                 ///< as learnt from them, YAML; empty: nothing is learnt
  BagTimes times;
};

/// Reads the bag once, as the live nodes would receive it, and reviews the record at the end.
/// @param progress  counts messages as they are read
/// @throws std::runtime_error for a bag that cannot be read, or lacks a topic
BagOutcome calibrateBag(const BagJob& job, const BagSetup& setup,
                        std::atomic<std::uint64_t>* progress);

/// How many messages calibrateBag() will read. @throws as calibrateBag()
std::uint64_t countMessages(const BagJob& job, const BagSetup& setup);

/// Ids of the lights that a bag's bearings tell apart, in order.
/// @throws std::runtime_error as calibrateBag(), and for a bag without bearings
std::vector<std::int32_t> listLights(const std::string& bag, const BagSetup& setup);

}  // namespace bearing_calibration::core
