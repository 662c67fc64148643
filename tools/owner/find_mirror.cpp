// Finds the rim of the mirror in images of a camera at rest in its rig: find_mirror --help

#include <boost/program_options.hpp>
#include <cmath>
#include <cstdio>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/optics/conic_mirror.h"
#include "bearing_calibration/vision/annotation.h"
#include "bearing_calibration/vision/mirror_rim.h"
#include "bearing_calibration_ros/detection_params.h"
#include "bearing_calibration_ros/parameter_files.h"
#include "tools/common/command_line.h"

namespace bearing_calibration::core {
namespace {

namespace options = boost::program_options;

constexpr double kFull = std::numeric_limits<std::uint16_t>::max();  // of the mean image

struct Arguments {
  std::vector<std::string> images;
  double radius_px = 0.0;
  std::string output_file;
  std::vector<double> principal_point_px;  ///< u, v; empty: not known
  double light_height_m = 0.0;
  std::vector<double> light_distances_m;
  std::vector<std::string> config_files;
};

/// False when only help was asked for. @throws options::error
bool parse(int argc, char** argv, Arguments* arguments) {
  options::options_description visible(
      "find_mirror IMAGE... [--radius PX] [--output OUT.png]\n"
      "            [--principal-point U V --light-height M --config FILE...]\n\n"
      "Finds the circle of the mirror's rim and prints its centre and radius as lines for\n"
      "your robot's file. Of several images the mean is taken: in images of a turning robot "
      "the\n"
      "surroundings smear and the rim stays.\n"
      "With the lens' principal point it also prints the calibration's parameters for a mirror\n"
      "that is tilted or offset from the lens' axis\n\nOptions");
  auto add = visible.add_options();
  add("help,h", "print this");
  add("radius", options::value(&arguments->radius_px)->default_value(0.0, "any"),
      "about what the rim's radius is, within a quarter [px]");
  add("output,o", options::value(&arguments->output_file), "picture of what was found, to write");
  add("principal-point", options::value(&arguments->principal_point_px)->multitoken(),
      "of the lens, from its calibration: u v [px]");
  add("light-height", options::value(&arguments->light_height_m),
      "of the light over the mirror's apex, to a centimetre; negative below it [m]");
  add("light-distances",
      options::value(&arguments->light_distances_m)->multitoken()->default_value({1.0, 3.0}, "1 3"),
      "least and largest one of the drive [m]");
  add("config,c", options::value(&arguments->config_files),
      "parameters that differ from config/detection.yaml: your lens and mirror; may be repeated");
  options::options_description hidden;
  hidden.add_options()("image", options::value(&arguments->images)->required(), "IMAGE");
  options::positional_options_description positions;
  positions.add("image", -1);
  const auto values = parseArguments(argc, argv, visible, hidden, positions);
  if (!values) return false;
  const bool has_point = values->count("principal-point") > 0;
  if (has_point && arguments->principal_point_px.size() != 2) {
    throw options::error("--principal-point needs two numbers, u and v");
  }
  if (arguments->light_distances_m.size() != 2) {
    throw options::error("--light-distances needs two numbers, the least and the largest");
  }
  if (has_point != (values->count("light-height") > 0)) {
    throw options::error("--principal-point and --light-height go together");
  }
  if (!(std::isfinite(arguments->radius_px) && arguments->radius_px >= 0.0)) {
    throw options::error("--radius must be greater than 0");
  }
  return true;
}

/// In units of a 16-bit image.
cv::Mat readGrey(const std::string& file) {
  const cv::Mat image = cv::imread(file, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH);
  if (image.empty()) throw std::runtime_error(file + ": is no image that can be read");
  if (image.depth() == CV_16U) return image;
  cv::Mat wide;
  image.convertTo(wide, CV_16U, kFull / std::numeric_limits<std::uint8_t>::max());
  return wide;
}

/// A pixel that is full in one of the images is full in the mean.
cv::Mat meanOf(const std::vector<std::string>& files) {
  cv::Mat sum, full;
  for (const std::string& file : files) {
    const cv::Mat image = readGrey(file);
    if (sum.empty()) {
      sum = cv::Mat::zeros(image.size(), CV_64F);
      full = cv::Mat::zeros(image.size(), CV_8U);
    }
    if (image.size() != sum.size()) {
      throw std::runtime_error(file + ": is of another size than " + files.front());
    }
    cv::accumulate(image, sum);
    full |= image == kFull;
  }
  cv::Mat mean;
  sum.convertTo(mean, CV_16U, 1.0 / static_cast<double>(files.size()));
  mean.setTo(kFull, full);
  return mean;
}

RimSearch searchFor(const Arguments& arguments, const cv::Mat& image) {
  constexpr double kRadiusError = 0.25;
  RimSearch search = rimSearchIn(image);
  if (arguments.radius_px > 0.0) {
    search.radius_px = {(1.0 - kRadiusError) * arguments.radius_px,
                        (1.0 + kRadiusError) * arguments.radius_px};
  }
  return search;
}

/// Where the image's centre is best put, and what the calibration must know for it.
struct BestCentre {
  Eigen::Vector2d centre_px;
  std::optional<MirrorMisalignment> bend;
};

/// Lens and mirror of the files, which need not have yet what is only being found out.
/// @throws std::runtime_error with every number that is missing or wrong
ConicMirror readMirror(const MirrorRim& rim, const cv::Size& image,
                       const std::vector<std::string>& config_files) {
  namespace ros_side = bearing_calibration_ros;
  ros_side::ParameterFiles files;
  files.addNode("calibration", ros_side::packagedConfig("calibration.yaml"));  // knows the wheels
  files.addNode("detection", ros_side::packagedConfig("detection.yaml"));
  files.addNode("drive", ros_side::packagedConfig("drive.yaml"));  // its limits are the robot's
  for (const std::string& found :
       {formatted("sensor/width=%d", image.width), formatted("sensor/height=%d", image.height),
        formatted("mirror/centre_u=%.3f", rim.circle.centre_px.x()),
        formatted("mirror/centre_v=%.3f", rim.circle.centre_px.y()),
        std::string("mask/inner_radius=0.0"),
        formatted("mask/outer_radius=%.3f", rim.circle.radius_px),
        formatted("mask/last_row=%d", image.height - 1)}) {
    files.set(found);
  }
  for (const std::string& file : config_files) files.overlay(file);
  files.set("mirror/kind=cone");  // else the optics need not be known
  return ros_side::readConfig<ros_side::DetectionNodeConfig>(files.reader("detection"))
      .detector.mirror;
}

BestCentre bestCentre(const MirrorRim& rim, const cv::Size& image, const Arguments& arguments) {
  if (arguments.principal_point_px.empty()) return {rim.circle.centre_px, std::nullopt};
  const ConicMirror mirror = readMirror(rim, image, arguments.config_files);
  const MirrorMisalignment bend =
      mirrorMisalignment(mirror, arguments.light_height_m, arguments.light_distances_m.front(),
                         arguments.light_distances_m.back());
  const Eigen::Vector2d principal_px(arguments.principal_point_px.front(),
                                     arguments.principal_point_px.back());
  return {principal_px + bend.centre_part * (rim.circle.centre_px - principal_px), bend};
}

void print(const MirrorRim& rim, const BestCentre& best) {
  constexpr double kPercent = 100.0;
  std::printf(
      "mirror:\n"
      "  centre_u: %.3f  # [px] +- %.3f\n"
      "  centre_v: %.3f  # [px] +- %.3f\n"
      "# rim: radius %.2f +- %.2f px about (%.3f, %.3f), seen in %.0f %% of the directions, "
      "its edge within %.2f px (1 sigma)\n"
      "mask:\n"
      "  outer_radius: %.0f.0  # [px] inside the rim\n",
      best.centre_px.x(), rim.stddev(0), best.centre_px.y(), rim.stddev(1), rim.circle.radius_px,
      rim.stddev(2), rim.circle.centre_px.x(), rim.circle.centre_px.y(),
      kPercent * rim.visible_part, rim.scatter_px, std::floor(rim.circle.radius_px));
  if (!best.bend) return;
  std::printf(
      "alignment:  # the centre above is %.2f of the way from the principal point to the rim's "
      "centre\n"
      "  near_per_far: %.3f  # [m] so much more a misaligned mirror does to near lights, about "
      "that centre\n"
      "  nearness_stddev: 0.001  # [rad m] beyond that, for a light's height known to 1 cm\n",
      best.bend->centre_part, best.bend->near_per_far_m);
}

void find(const Arguments& arguments) {
  const cv::Mat image = meanOf(arguments.images);
  const auto rim = findMirrorRim(image, searchFor(arguments, image));
  if (!rim) {
    throw std::runtime_error(
        "no rim found: a circle about the image's middle must be seen in a third of the directions "
        "(more light, more images of a turning robot, or --radius help)");
  }
  print(*rim, bestCentre(*rim, image.size(), arguments));
  if (arguments.output_file.empty()) return;
  if (!cv::haveImageWriter(arguments.output_file) ||
      !cv::imwrite(arguments.output_file, annotateRim(image, *rim))) {
    throw std::runtime_error(arguments.output_file + ": cannot be written, or is of no known kind");
  }
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  using namespace bearing_calibration::core;
  return runProgram("find_mirror", argc, argv, parse, find);
}
