// What a calibration drive brings: planned by the robot, scripted, and the best that is known.
// drive_table --help

#include <algorithm>
#include <boost/program_options.hpp>
#include <cstdio>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/simulation/robot_simulator.h"
#include "bearing_calibration/vision/light_bearings.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/default_rig.h"
#include "support/rendered_observations.h"
#include "tools/common/command_line.h"
#include "tools/common/parallel.h"
#include "tools/study/best_drive.h"
#include "tools/study/drive_summary.h"
#include "tools/study/monte_carlo_bars.h"

namespace bearing_calibration::core {
namespace {

namespace options = boost::program_options;

constexpr int kBarMissed = 1;

struct Arguments {
  std::string what;
  int runs = 0;
  int changes = 0;
  int threads = 0;
  double duration_s = 0.0;
  bool random_noise = false;
  bool estimate_noise = false;
  bool each = false;
};

options::options_description describeOptions(Arguments* arguments) {
  options::options_description description(
      "drive_table [--what motions|best|rooms|far|views|images|all] [options]\n\n"
      "Exit status 1 when a bar of doc/how-to/driving.md is missed");
  auto add = description.add_options();
  add("help,h", "print this");
  add("what", options::value(&arguments->what)->default_value("all"),
      "motions: the same time driven in different ways, from random mounts; best: the best drive "
      "that is found by somebody who knows mount and light; rooms: without an initial guess until "
      "converged, "
      "the light anywhere in 0.5 to 3 m; far: the same, the light in 2.5 to 6 m; views: the rooms "
      "with sensors that see a part of a "
      "turn only; images: ten of "
      "the rooms with rendered images and the detector");
  add("runs", options::value(&arguments->runs)->default_value(100), "of each motion, and rooms");
  add("changes", options::value(&arguments->changes)->default_value(20000),
      "tried in the search for the best drive");
  add("threads", options::value(&arguments->threads)->default_value(2), "at work");
  add("duration", options::value(&arguments->duration_s)->default_value(100.0),
      "of a drive of motions and best [s]");
  add("random-noise", options::bool_switch(&arguments->random_noise),
      "robots noisier or less so than stated, as those of monte_carlo");
  add("estimate-noise", options::bool_switch(&arguments->estimate_noise),
      "the calibration estimates the levels of the noise, as it does by default");
  add("each", options::bool_switch(&arguments->each), "a line for each run");
  return description;
}

std::vector<DriveRecord> driveAll(const Arguments& arguments,
                                  const std::function<DrivenCase(std::uint64_t)>& caseOf) {
  std::vector<DriveRecord> records(static_cast<std::size_t>(arguments.runs));
  forEachInParallel(records.size(), arguments.threads, [&](std::size_t i) {
    const std::uint64_t seed = i + 1;
    DrivenCase driven = caseOf(seed);
    if (arguments.random_noise) drawNoise(driven.simulated, seed);
    if (arguments.estimate_noise) driven.simulated.noise_looked_for = usualNoise();
    records[i] = drive(driven);
  });
  return records;
}

/// The ways to drive for the same time, with the bars of the planned one.
bool printMotions(const Arguments& arguments) {
  std::printf("%s", motionHeader().c_str());
  bool all_reached = true;
  for (const DrivenMotion& motion : comparedMotions()) {
    const std::vector<DriveRecord> records = driveAll(arguments, [&](std::uint64_t seed) {
      return motionCase(motion, seed, arguments.duration_s);
    });
    if (arguments.each) std::printf("%s", formatEach(records).c_str());
    const MotionSummaryRow row = summarise(records);
    std::printf("%s", format(motion.name, row).c_str());
    std::fflush(stdout);
    if (motion.motion != DriveMotion::kOptimal) continue;
    const std::vector<Bar> bars = judgeBars(row);
    std::printf("%s", format(bars).c_str());
    all_reached = allReached(bars);
  }
  return all_reached;
}

void printBest(const Arguments& arguments) {
  const DrivenCase driven = motionCase(comparedMotions().front(), 1, arguments.duration_s);
  const BestDrive best = findBestDrive(driven, arguments.duration_s, arguments.changes, 1);
  std::printf("best found offline: figure %.3f, nearest %.2f m\n",
              polarFigure(best.mount_covariance, kPaperRho_m), best.least_distance_m);
  for (const MotionPrimitive& primitive : best.primitives) {
    std::printf("  turn %5.0f deg, go %5.2f m\n", degreesFromRadians(primitive.turn_rad),
                primitive.length_m);
  }
}

bool printRooms(const Arguments& arguments,
                const std::function<DrivenCase(std::uint64_t)>& caseOf) {
  const std::vector<DriveRecord> records = driveAll(arguments, caseOf);
  if (arguments.each) std::printf("%s", formatEach(records).c_str());
  const RoomSummary summary = summariseRooms(records);
  std::printf("%s", format(summary).c_str());
  const std::vector<Bar> bars = judgeBars(summary);
  std::printf("%s", format(bars).c_str());
  return allReached(bars);
}

/// Each field of view with the bars of a planner that knows it.
bool printViews(const Arguments& arguments) {
  std::printf("%s", viewHeader().c_str());
  bool all_reached = true;
  for (const double width_deg : {360.0, 180.0, 90.0, 60.0}) {
    const double width_rad = radiansFromDegrees(width_deg);
    for (const bool is_known : {true, false}) {
      if (width_deg == 360.0 && !is_known) continue;
      const std::vector<DriveRecord> records = driveAll(
          arguments, [&](std::uint64_t seed) { return viewCase(seed, width_rad, is_known); });
      if (arguments.each) std::printf("%s", formatEach(records).c_str());
      const RoomSummary summary = summariseRooms(records);
      std::printf("%s", formatView(width_rad, is_known, summary).c_str());
      std::fflush(stdout);
      if (is_known) all_reached = allReached(judgeBars(summary)) && all_reached;
    }
  }
  return all_reached;
}

struct SimulatedCamera {
  explicit SimulatedCamera(const RendererConfig& config)
      : renderer(config, test::plainWall), detector(test::detectorOf(config)) {}
  ImageRenderer renderer;
  LightDetector detector;
  std::uint64_t images = 0;
};

RendererConfig cameraConfig(std::uint64_t seed) {
  RendererConfig config = test::renderedRig();
  config.rays_per_light = 4096;  // as config/simulation.yaml has it
  config.seed = seed;
  return config;
}

/// A camera under its mirror, rendered, and the detector that finds the light in its images, both
/// as they are shipped, with an exposure control. For DrivenCase::look.
std::function<BearingSet(const RobotSimulator&)> imageLook(std::uint64_t seed) {
  const auto camera = std::make_shared<SimulatedCamera>(cameraConfig(seed));
  return [camera](const RobotSimulator& robot) {
    std::vector<Light> lights = robot.lights();
    for (Light& light : lights) {
      light.height_m = test::kDefaultLightHeight_m;
      // makes up for the distance, as an exposure control does
      light.brightness = (light.position_m - robot.worldFromSensor().position_m).squaredNorm();
    }
    const cv::Mat image =
        camera->renderer.render(lights, {robot.worldFromSensor()}, camera->images++);
    const DetectionResult& found = camera->detector.detect(image);
    return bearingsFromLights(found.lights, {}, robot.now(), image.rows);
  };
}

DrivenCase roomWithImages(std::uint64_t seed) {
  DrivenCase driven = roomCase(seed);
  driven.look = imageLook(seed);
  return driven;
}

bool printImages(Arguments arguments) {
  constexpr int kMostRuns = 10;  // a minute each
  arguments.runs = std::min(arguments.runs, kMostRuns);
  std::printf("with images, ");
  return printRooms(arguments, roomWithImages);
}

int run(int argc, char** argv) {
  Arguments arguments;
  const options::options_description description = describeOptions(&arguments);
  const auto values = parseArguments(argc, argv, description);
  if (!values) return EXIT_SUCCESS;
  requireGreaterThan0("runs", arguments.runs);
  requireGreaterThan0("threads", arguments.threads);
  requireGreaterThan0("duration", arguments.duration_s);
  const std::vector<std::string> known = {"all", "motions", "best",  "rooms",
                                          "far", "views",   "images"};
  if (std::find(known.begin(), known.end(), arguments.what) == known.end()) {
    throw std::invalid_argument(
        "--what must be all, motions, best, rooms, far, views or images, but is " + arguments.what);
  }
  const auto wants = [&](const char* what) {
    return arguments.what == "all" || arguments.what == what;
  };
  bool all_reached = true;
  if (wants("motions")) all_reached = printMotions(arguments) && all_reached;
  if (wants("best")) printBest(arguments);
  if (wants("rooms")) all_reached = printRooms(arguments, roomCase) && all_reached;
  if (wants("far")) {
    std::printf("far ");
    all_reached = printRooms(arguments, farRoomCase) && all_reached;
  }
  if (wants("views")) all_reached = printViews(arguments) && all_reached;
  if (wants("images")) all_reached = printImages(arguments) && all_reached;
  return all_reached ? 0 : kBarMissed;
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  return bearing_calibration::core::runProgram(
      "drive_table", [&] { return bearing_calibration::core::run(argc, argv); },
      bearing_calibration::core::kUsageError);
}
