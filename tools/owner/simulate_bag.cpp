// A drive of the simulated robot as a bag, without a ROS master: simulate_bag --help

#include <boost/program_options.hpp>
#include <iostream>
#include <string>
#include <vector>

#include "bearing_calibration/WheelTicks.h"
#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/simulation/robot_simulator.h"
#include "bearing_calibration/simulation/scene.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/simulated_camera.h"
#include "tools/common/command_line.h"
#include "tools/owner/bag_writer.h"
#include "tools/owner/simulated_scene.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;
namespace options = boost::program_options;

/// Without images: as a laser scanner's that sees a post.
constexpr double kBearingStddev_rad = core::radiansFromDegrees(0.1);

struct Arguments {
  SceneArguments scene;
  std::string output_file;
  double seconds = 0.0;
  bool only_bearings = false;
};

/// False when only help was asked for. @throws options::error
bool parse(int argc, char** argv, Arguments* arguments) {
  constexpr double kDefaultDrive_s = 80.0;  // enough to converge
  options::options_description description(
      "simulate_bag --output FILE [--seconds S] [--scene FILE]... [--seed N] [--only-bearings]\n\n"
      "Writes what the demo's robot would have recorded: wheel_ticks and camera/image_raw (or\n"
      "bearings), the same for the same seed\n\nOptions");
  auto add = description.add_options();
  add("help,h", "print this");
  add("output,o", options::value(&arguments->output_file)->required(), "bag to write");
  add("seconds", options::value(&arguments->seconds)->default_value(kDefaultDrive_s),
      "of driving [s]");
  arguments->scene.addTo(&description);
  add("only-bearings", options::bool_switch(&arguments->only_bearings),
      "bearings with a noise of 0.1 deg instead of images: a thousandth of the size");
  if (!core::parseArguments(argc, argv, description)) return false;
  core::requireGreaterThan0("seconds", arguments->seconds);
  return true;
}

/// Writes one kind of message after the other as the simulation goes on.
class Recorder {
 public:
  Recorder(const SimulationNodeConfig& config, const core::Scene& scene, const std::string& file)
      : config_(config),
        scene_(scene),
        renderer_(config.renderer, scene.surroundings),
        bag_(file) {}

  void write(const core::WheelCounts& ticks) {
    bearing_calibration::WheelTicks message;
    message.header.stamp = rosFromStamp(ticks.stamp);
    message.left = ticks.left_ticks;
    message.right = ticks.right_ticks;
    bag_.write("/wheel_ticks", message.header.stamp, message);
  }

  void write(const core::BearingSet& bearings) {
    const bearing_calibration::LightBearings message =
        messageFromBearings(bearings, config_.frames.sensor);
    bag_.write("/bearings", message.header.stamp, message);
  }

  void photograph(core::Stamp stamp, const core::SensorMotion& motion, bool lights_occluded) {
    static const std::vector<core::Light> kDarkness;
    const sensor_msgs::ImagePtr message = messageFromRendered(
        renderer_.render(lights_occluded ? kDarkness : scene_.lights, motion, images_++),
        config_.renderer.encoding);
    message->header.stamp = rosFromStamp(stamp);
    message->header.frame_id = config_.frames.sensor;
    bag_.write("/camera/image_raw", message->header.stamp, *message);
  }

  void finish() { bag_.finish(); }
  std::uint64_t images() const { return images_; }

 private:
  const SimulationNodeConfig& config_;
  const core::Scene& scene_;
  core::ImageRenderer renderer_;
  core::BagWriter bag_;
  std::uint64_t images_ = 0;
};

void record(const Arguments& arguments) {
  SimulationNodeConfig config = readSimulatedScene(arguments.scene);
  const core::Scene scene = core::drawScene(config.scene, config.seed);
  config.renderer.holders = scene.holders;
  config.robot.sensor.stddev_rad = kBearingStddev_rad;
  core::RobotSimulator simulator(
      config.robot, scene.lights,
      core::makeTrajectory(config.driving.trajectory,
                           config.robot.encoders.drive.wheel_separation_m));
  Recorder recorder(config, scene, arguments.output_file);
  while (simulator.timeSeconds() < arguments.seconds) {
    const core::Stamp stamp =
        simulator.now() + core::durationFromSeconds(config.robot.stamp_latency_s);
    const bool lights_occluded = simulator.lightsOccluded();
    if (const auto ticks = simulator.readTicks()) recorder.write(*ticks);
    const bool image_is_due = simulator.bearingsDue() && !arguments.only_bearings;
    if (arguments.only_bearings) {
      if (const auto bearings = simulator.readBearings()) recorder.write(*bearings);
    }
    const core::Pose2 world_from_start = simulator.worldFromSensor();
    simulator.step();
    if (!image_is_due) continue;
    const core::SensorMotion motion =
        core::motionBetween(world_from_start, simulator.worldFromSensor(), config.robot.step_s);
    recorder.photograph(stamp, motion, lights_occluded);
  }
  recorder.finish();
  std::cout << arguments.output_file << ": " << arguments.seconds << " s, " << recorder.images()
            << " images\n";
}

}  // namespace
}  // namespace bearing_calibration_ros

int main(int argc, char** argv) {
  using namespace bearing_calibration_ros;
  return core::runProgram("simulate_bag", argc, argv, parse, record);
}
