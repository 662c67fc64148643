// A fit that is taken over after the last input: what it says is published and saved.

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <ros/ros.h>

#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "bearing_calibration_ros/calibration_publisher.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/result_saver.h"
#include "support/simulated_calibration.h"
#include "support/some_calibration.h"
#include "support/temporary_folder.h"

namespace bearing_calibration_ros {
namespace {

using std::chrono::steady_clock;

::testing::AssertionResult comes(const std::function<bool()>& condition) {
  constexpr std::chrono::seconds kDeadline{60};
  const auto deadline = steady_clock::now() + kDeadline;
  while (!condition()) {
    if (steady_clock::now() > deadline) return ::testing::AssertionFailure();
    ros::spinOnce();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return ::testing::AssertionSuccess();
}

/// Plays a drive until there is a mount and a fit under way, which no input takes over.
class FitUnderWay {
 public:
  explicit FitUnderWay(core::Calibrator* calibrator) : calibrator_(calibrator) {}

  void reach() {
    for (bool is_reached = false; !is_reached; ++tick_) {
      ASSERT_LT(tick_, record_.ticks.size());
      const core::Stamp now = record_.ticks[tick_].stamp;
      for (; image_ < record_.bearings.size() && record_.bearings[image_].stamp <= now; ++image_) {
        calibrator_->addBearings(record_.bearings[image_], now);
      }
      calibrator_->addTicks(record_.ticks[tick_], now);
      is_reached = calibrator_->fits().under_way && calibrator_->result().base_from_sensor;
      if (!is_reached) waitForFit();  // on a busy machine the drive would end before the search
    }
  }

  void waitForFit() {
    ASSERT_TRUE(comes([&] {
      calibrator_->takeOverFit();
      return !calibrator_->fits().under_way;
    }));
  }

 private:
  core::Calibrator* calibrator_;
  core::SimulatedRecord record_ = core::testing::simulate(core::testing::paperRobot(1), 200.0);
  std::size_t tick_ = 0;
  std::size_t image_ = 0;
};

/// The poses that are published.
struct Listener {
  void takePose(const geometry_msgs::PoseWithCovarianceStamped& said) {
    pose = said;
    ++poses;
  }
  void takeTransform(const geometry_msgs::TransformStamped& said) { transform = said; }
  bool says(const core::CalibrationResult& result) const {
    const double x_m = result.base_from_sensor->mean.x();
    return pose.pose.pose.position.x == x_m && transform.transform.translation.x == x_m;
  }

  geometry_msgs::PoseWithCovarianceStamped pose;
  geometry_msgs::TransformStamped transform;
  int poses = 0;
};

TEST(CalibrationPublisher, PublishesWhatALateFitSays) {
  CalibrationNodeConfig config;
  config.frames = {"base_link", "camera"};
  config.calibrator = core::testing::calibratorConfig();
  core::Calibrator calibrator(config.calibrator, core::FitsRun::kBeside);
  ros::NodeHandle node_handle("late_fit");
  CalibrationPublisher publisher(node_handle, config, &calibrator);
  Listener heard;
  const ros::Subscriber poses =
      node_handle.subscribe("base_from_camera", 10, &Listener::takePose, &heard);
  const ros::Subscriber transforms =
      node_handle.subscribe("transform", 10, &Listener::takeTransform, &heard);
  FitUnderWay drive(&calibrator);
  core::CalibrationResult before;
  core::CalibrationResult after;
  do {
    drive.reach();
    ASSERT_FALSE(HasFatalFailure());
    publisher.publishEstimate();
    before = calibrator.result();
    drive.waitForFit();
    after = calibrator.result();
  } while (after.base_from_sensor == before.base_from_sensor);
  ASSERT_EQ(after.stamp, before.stamp);
  ASSERT_TRUE(comes([&] { return heard.says(before); }));
  publisher.publishEstimate();
  ASSERT_TRUE(comes([&] { return heard.says(after); }));
  EXPECT_GT(heard.pose.header.stamp, rosFromStamp(before.stamp)) << "none is sent twice";
  EXPECT_EQ(heard.transform.header.stamp, heard.pose.header.stamp);
  EXPECT_EQ(heard.pose.pose.covariance[0], after.base_from_sensor->covariance(0, 0));

  const int count = heard.poses;
  publisher.publishEstimate();  // no news
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ros::spinOnce();
  EXPECT_EQ(heard.poses, count);
}

// Promise kept: a fit that ends after the last input
TEST(ResultSaver, SavesWhatALateFitSays) {
  const core::TemporaryFolder folder;
  CalibrationNodeConfig config;
  config.frames = {"base_link", "camera"};
  config.output.folder = folder.path() / "result";
  config.calibrator.converged = {0.01, 0.005};
  const core::SavedCalibration some = core::someCalibration();
  config.unestimated_mount = some.unestimated;
  config.calibrator.drive = some.provenance.drive;
  core::CalibrationResult result = some.result;
  result.estimate = core::StateEstimate::of(*result.cartesian_state);
  ros::NodeHandle node_handle;
  std::timed_mutex callback_mutex;
  const auto saved = [&] {
    const auto content = core::readResultFile(core::resultPathIn(config.output.folder));
    EXPECT_EQ(content.error, "");
    return content.calibration;
  };
  {
    ResultSaver saver(
        node_handle, config, "late_fit", "inputs", [&] { return result; }, &callback_mutex);
    saver.check();
    ASSERT_TRUE(saved());
    EXPECT_EQ(saved()->result.base_from_sensor, result.base_from_sensor);
    result.base_from_sensor->mean.x() += 1e-4;
    result.base_from_sensor->covariance *= 0.5;
  }
  EXPECT_EQ(saved()->result.base_from_sensor, result.base_from_sensor);
}

}  // namespace
}  // namespace bearing_calibration_ros
