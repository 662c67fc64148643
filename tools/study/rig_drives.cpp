// How a calibration from images ends on a rig that differs from its configuration in one value: the
// demo's drive, detection and calibration in one loop, without a master.
//
//     rig_drives --help

#include <boost/program_options.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/simulation/robot_simulator.h"
#include "bearing_calibration/simulation/scene.h"
#include "bearing_calibration_ros/image_bearings.h"
#include "bearing_calibration_ros/parameter_files.h"
#include "bearing_calibration_ros/simulated_camera.h"
#include "tools/common/command_line.h"
#include "tools/owner/bag_calibration.h"
#include "tools/owner/simulated_scene.h"
#include "tools/study/wrong_rigs.h"

namespace bearing_calibration::core {
namespace {

namespace options = boost::program_options;
namespace ros_side = bearing_calibration_ros;

constexpr double kLate_s = 20.0;  // the end of a drive that is looked at alone

struct DriveArguments {
  ros_side::SceneArguments scene;
  double seconds = 0.0;
  std::string rig;  ///< only those whose name has this in it
  bool learns = true;
};

/// False when only help was asked for. @throws options::error
bool parse(int argc, char** argv, DriveArguments* arguments) {
  options::options_description description(
      "rig_drives [--seconds S] [--rig PART OF NAME] [--as-configured] [--scene FILE]...\n"
      "           [--seed N]\n\n"
      "Prints how the calibration of the demo's drive ends on rigs that are not as configured");
  auto add = description.add_options();
  add("help,h", "print this");
  add("seconds", options::value(&arguments->seconds)->default_value(60.0), "of driving");
  add("rig", options::value(&arguments->rig), "only the rigs whose name has this in it");
  bool as_configured = false;
  add("as-configured", options::bool_switch(&as_configured), "the optics are not learnt");
  arguments->scene.addTo(&description);
  if (!parseArguments(argc, argv, description)) return false;
  arguments->learns = !as_configured;
  requireGreaterThan0("seconds", arguments->seconds);
  return true;
}

/// Of the images in which the mask shows the light whole.
struct Tally {
  int seen = 0;
  int found = 0;  ///< a candidate near the truth is likely
  int wrong = 0;  ///< the likeliest candidate is likely and somewhere else

  double percent(int part) const { return seen > 0 ? 100.0 * part / seen : 0.0; }
};

class RigDrive {
 public:
  RigDrive(const ros_side::SimulationNodeConfig& config, const WrongRig& rig, const BagSetup& setup,
           bool learns)
      : config_(config),
        setup_(setup),
        rig_(rig),
        learns_(learns),
        scene_(drawScene(config.scene, config.seed)),
        renderer_(rig.rendered, scene_.surroundings),
        simulator_(config.robot, scene_.lights,
                   makeTrajectory(config.driving.trajectory,
                                  config.robot.encoders.drive.wheel_separation_m)),
        images_(setup.detection),
        calibrator_(setup.calibration.calibrator) {
    for (Light& light : scene_.lights) light.height_m = rig.light_height_m;
  }

  void drive(double seconds) {
    std::uint64_t number = 0;
    while (simulator_.timeSeconds() < seconds) {
      const Stamp now = simulator_.now();
      if (const auto ticks = simulator_.readTicks()) calibrator_.addTicks(*ticks, now);
      const bool image_is_due = simulator_.bearingsDue();
      const bool is_late = simulator_.timeSeconds() >= seconds - kLate_s;
      const Pose2 world_from_start = simulator_.worldFromSensor();
      simulator_.step();
      if (!image_is_due) continue;
      const SensorMotion motion =
          motionBetween(world_from_start, simulator_.worldFromSensor(), config_.robot.step_s);
      look(now, motion, number++, is_late);
    }
  }

  void print() const;

 private:
  std::string describeOptics() const;
  void look(Stamp now, const SensorMotion& motion, std::uint64_t number, bool is_late) {
    const sensor_msgs::ImagePtr image = ros_side::messageFromRendered(
        renderer_.render(scene_.lights, motion, number), config_.renderer.encoding);
    image->header.stamp = ros_side::rosFromStamp(now);
    auto prediction = calibrator_.predictBearing(images_.middleOf(*image));
    if (prediction && !learns_) {
      prediction->distance_m = std::numeric_limits<double>::quiet_NaN();  // tells nothing
    }
    const BearingSet bearings = images_.detect(image, prediction);
    calibrator_.addBearings(bearings, now);
    const auto truth = renderer_.truthOf(scene_.lights.front(), motion);
    if (!truth || !showsWhole(truth->pixel)) return;
    count(bearings, truth->azimuth_rad, &all_);
    if (is_late) count(bearings, truth->azimuth_rad, &late_);
  }

  /// A spot that the configured mask or the image cuts is none.
  bool showsWhole(const Eigen::Vector2d& pixel) const {
    constexpr double kSpot_px = 16.0;
    const DetectorConfig& detector = setup_.detection.detector;
    const double radius_px = (pixel - detector.view.centre_px()).norm();
    return radius_px - detector.mask.inner_radius_px >= kSpot_px &&
           detector.mask.outer_radius_px - radius_px >= kSpot_px && pixel.y() >= kSpot_px &&
           detector.mask.last_row - pixel.y() >= kSpot_px;
  }

  static void count(const BearingSet& bearings, double azimuth_rad, Tally* tally) {
    constexpr double kNear_rad = radiansFromDegrees(5.0);  // a wrong rig moves the bearing, too
    const Bearing* likeliest = nullptr;
    bool found = false;
    const auto isNear = [&](const Bearing& bearing) {
      return std::abs(wrapAngle(bearing.azimuth_rad - azimuth_rad)) <= kNear_rad;
    };
    for (const Bearing& bearing : bearings.candidates) {
      if (bearing.probability < LightDetector::kLikely) continue;
      found = found || isNear(bearing);
      if (likeliest == nullptr || bearing.probability > likeliest->probability)
        likeliest = &bearing;
    }
    ++tally->seen;
    tally->found += found ? 1 : 0;
    tally->wrong += likeliest != nullptr && !isNear(*likeliest) ? 1 : 0;
  }

  const ros_side::SimulationNodeConfig& config_;
  const BagSetup& setup_;
  const WrongRig& rig_;
  const bool learns_;
  Scene scene_;
  ImageRenderer renderer_;
  RobotSimulator simulator_;
  ros_side::ImageBearings images_;
  Calibrator calibrator_;
  Tally all_;
  Tally late_;
};

/// Of each value the error in standard deviations, and these as a part of the configured ones.
std::string RigDrive::describeOptics() const {
  const CameraRig& truth = rig_.rendered.rig;
  const DetectorConfig& configured = setup_.detection.detector;
  const DetectorConfig learnt = images_.learner()->applied(configured);
  const OpticsUncertainty& now = learnt.optics_stddev;
  const OpticsUncertainty& before = configured.optics_stddev;
  const auto of = [](double off, double stddev, double stddev_before) {
    return formatted("%.1f (%.2f)", off / stddev, stddev / stddev_before);
  };
  return of(std::log(imageDistancePx(learnt.mirror) / truth.pixelsPerSlope()), now.scale,
            before.scale) +
         ", " +
         of(std::log(learnt.mirror.aperture_m / truth.aperture_m), now.aperture, before.aperture) +
         ", " +
         of(std::log(learnt.mirror.focus_distance_m / truth.focus_distance_m), now.focus,
            before.focus) +
         ", " +
         of(learnt.mirror.half_angle_rad - truth.cone_half_angle_rad, now.half_angle_rad,
            before.half_angle_rad);
}

void RigDrive::print() const {
  const CalibrationResult result = calibrator_.result();
  std::printf("| %s | %d | %.1f | %.1f | %d | %s |", rig_.name.c_str(), all_.seen,
              all_.percent(all_.found), late_.percent(late_.found), all_.wrong,
              nameOf(result.state));
  if (result.base_from_sensor) {
    const Pose2& truth = config_.robot.base_from_sensor;
    const MountEstimate& mount = *result.base_from_sensor;
    const Eigen::Vector3d error =
        mountDifference(mount.mean, {truth.position_m.x(), truth.position_m.y(), truth.yaw_rad});
    const Eigen::Vector3d stddev = mount.covariance.diagonal().cwiseSqrt();
    const Eigen::Vector3d sigmas = error.cwiseQuotient(stddev);
    std::printf(" %.1f, %.1f, %.2f | %.1f, %.1f, %.2f | %.1f, %.1f, %.1f |", 1e3 * error.x(),
                1e3 * error.y(), degreesFromRadians(error.z()), 1e3 * stddev.x(), 1e3 * stddev.y(),
                degreesFromRadians(stddev.z()), sigmas.x(), sigmas.y(), sigmas.z());
  } else {
    std::printf(" | | |");
  }
  std::printf(" %s |\n", describeOptics().c_str());
  std::fflush(stdout);
}

int run(int argc, char** argv) {
  DriveArguments arguments;
  if (!parse(argc, argv, &arguments)) return EXIT_SUCCESS;
  const ros_side::SimulationNodeConfig config = ros_side::readSimulatedScene(arguments.scene);
  const BagSetup setup = readBagSetup({ros_side::packagedConfig("robots/simulated.yaml")}, {}, {});
  std::printf(
      "| wrong | seen | found %% | in the last %.0f s %% | wrong | state | error [mm, mm, deg] | "
      "standard deviation | error in these | optics |\n|---|---|---|---|---|---|---|---|---|---|\n",
      kLate_s);
  for (const WrongRig& rig : wrongRigs(config.renderer)) {
    if (rig.name.find(arguments.rig) == std::string::npos) continue;
    RigDrive drive(config, rig, setup, arguments.learns);
    drive.drive(arguments.seconds);
    drive.print();
  }
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  namespace package = bearing_calibration::core;
  return package::runProgram("rig_drives", [&] { return package::run(argc, argv); });
}
