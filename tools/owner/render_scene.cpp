// Images of a scene as the simulated robot's camera takes them, with the truth: render_scene --help

#include <boost/program_options.hpp>
#include <cinttypes>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bearing_calibration_ros/simulation_params.h"
#include "tools/common/command_line.h"
#include "tools/owner/simulated_scene.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;
namespace options = boost::program_options;

struct Arguments {
  SceneArguments scene;
  std::filesystem::path folder;
  int images = 0;
};

/// False when only help was asked for. @throws options::error
bool parse(int argc, char** argv, Arguments* arguments) {
  constexpr int kDefaultImages = 10;  // a second of driving
  options::options_description description(
      "render_scene --output FOLDER [--scene FILE]... [--seed N] [--images N]\n\n"
      "Writes what the simulated camera sees while the robot drives, image by image, with "
      "truth.csv\n"
      "(where each light is) and detection.yaml (what a detector needs to know of this scene)\n\n"
      "Options");
  std::string folder;
  auto add = description.add_options();
  add("help,h", "print this");
  add("output,o", options::value(&folder)->required(), "folder to write into, made when missing");
  arguments->scene.addTo(&description);
  add("images", options::value(&arguments->images)->default_value(kDefaultImages), "how many");
  if (!core::parseArguments(argc, argv, description)) return false;
  arguments->folder = folder;
  core::requireGreaterThan0("images", arguments->images);
  return true;
}

/// Drives the robot from one image to the next.
class Photographer {
 public:
  explicit Photographer(const SimulationNodeConfig& config)
      : step_s_(config.robot.step_s),
        simulator_(config.robot, config.scene.lights,
                   core::makeTrajectory(config.driving.trajectory,
                                        config.robot.encoders.drive.wheel_separation_m)) {}

  struct Shot {
    core::Stamp stamp;
    core::SensorMotion motion;
  };
  Shot next() {
    while (!simulator_.bearingsDue()) simulator_.step();
    Shot shot{simulator_.now(), {}};
    const core::Pose2 world_from_start = simulator_.worldFromSensor();
    simulator_.step();
    shot.motion = core::motionBetween(world_from_start, simulator_.worldFromSensor(), step_s_);
    return shot;
  }

 private:
  double step_s_;
  core::RobotSimulator simulator_;
};

std::ofstream open(const std::filesystem::path& file) {
  std::ofstream stream(file);
  if (!stream) throw std::runtime_error(file.string() + ": cannot be written");
  return stream;
}

void close(std::ofstream* stream, const std::filesystem::path& file) {
  stream->close();
  if (!*stream) throw std::runtime_error(file.string() + ": cannot be written");
}

/// What of config/detection.yaml depends on the scene.
void writeDetection(const core::RendererConfig& renderer, const std::filesystem::path& file) {
  std::ofstream stream = open(file);
  stream << "# What the light detection needs to know of this scene, in place of the values of\n"
            "# config/detection.yaml.\n"
         << "time:\n  row_time: " << std::fixed << std::setprecision(9)
         << renderer.shutter.row_time_s << "\nmask:\n  posts: [";
  const char* separator = "";
  for (const core::MirrorHolder& holder : renderer.holders) {
    stream << separator << "[" << holder.azimuth_rad << ", " << holder.half_width_rad << "]";
    separator = ", ";
  }
  stream << "]\n";
  close(&stream, file);
}

std::string imageName(int number, const core::ImageEncoding& encoding) {
  constexpr int kDigits = 6;
  std::ostringstream name;
  name << std::setw(kDigits) << std::setfill('0') << number
       << (encoding.jpeg_quality > 0 ? ".jpg" : ".png");
  return name.str();
}

void writeImage(const cv::Mat& image, core::ImageEncoding encoding,
                const std::filesystem::path& file) {
  std::vector<int> quality;
  if (encoding.jpeg_quality > 0) quality = {cv::IMWRITE_JPEG_QUALITY, encoding.jpeg_quality};
  encoding.jpeg_quality = 0;  // the file is what is compressed
  if (!cv::imwrite(file.string(), core::encode(image, encoding), quality)) {
    throw std::runtime_error(file.string() + ": cannot be written");
  }
}

void render(const Arguments& arguments) {
  SimulationNodeConfig config = readSimulatedScene(arguments.scene);
  const core::Scene scene = core::drawScene(config.scene, config.seed);
  config.renderer.holders = scene.holders;
  core::ImageRenderer renderer(config.renderer, scene.surroundings);
  Photographer photographer(config);

  std::filesystem::create_directories(arguments.folder);
  writeDetection(config.renderer, arguments.folder / "detection.yaml");
  const std::filesystem::path truth_file = arguments.folder / "truth.csv";
  std::ofstream truth = open(truth_file);
  truth << "image,light,stamp_s,row_stamp_s,azimuth_rad,elevation_rad,column_px,row_px\n"
        << std::fixed << std::setprecision(9);
  for (int i = 0; i < arguments.images; ++i) {
    const Photographer::Shot shot = photographer.next();
    const std::string name = imageName(i, config.renderer.encoding);
    writeImage(renderer.render(scene.lights, shot.motion, static_cast<std::uint64_t>(i)),
               config.renderer.encoding, arguments.folder / name);
    const double stamp_s = core::secondsFromDuration(shot.stamp - config.robot.start);
    for (std::size_t light = 0; light < config.scene.lights.size(); ++light) {
      const auto seen = renderer.truthOf(config.scene.lights[light], shot.motion);
      if (!seen) continue;
      truth << name << "," << light << "," << stamp_s << "," << stamp_s + seen->time_s << ","
            << seen->azimuth_rad << "," << seen->elevation_rad << "," << seen->pixel.x() << ","
            << seen->pixel.y() << "\n";
    }
  }
  close(&truth, truth_file);
  std::cout << arguments.folder.string() << ": " << arguments.images << " images, truth.csv, "
            << "detection.yaml\n";
}

}  // namespace
}  // namespace bearing_calibration_ros

int main(int argc, char** argv) {
  using namespace bearing_calibration_ros;
  return core::runProgram("render_scene", argc, argv, parse, render);
}
