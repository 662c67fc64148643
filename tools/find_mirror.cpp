// Finds the rim of the mirror in images of a camera at rest in its rig: find_mirror --help

#include <boost/program_options.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "bearing_calibration/vision/annotation.h"
#include "bearing_calibration/vision/mirror_rim.h"
#include "tools/command_line.h"

namespace bearing_calibration {
namespace {

namespace options = boost::program_options;

constexpr double kFull = std::numeric_limits<std::uint16_t>::max();  // of the mean image

struct Arguments {
  std::vector<std::string> images;
  double radius_px = 0.0;
  std::string output_file;
};

/// False when only help was asked for. @throws options::error
bool parse(int argc, char** argv, Arguments* arguments) {
  options::options_description visible(
      "find_mirror IMAGE... [--radius PX] [--output OUT.png]\n\n"
      "Finds the circle of the mirror's rim and prints its centre and radius as lines for\n"
      "config/detection.yaml. Of several images the mean is taken: in images of a turning robot "
      "the\n"
      "surroundings smear and the rim stays");
  auto add = visible.add_options();
  add("help,h", "print this");
  add("radius", options::value(&arguments->radius_px)->default_value(0.0, "any"),
      "about what the rim's radius is, within a quarter [px]");
  add("output,o", options::value(&arguments->output_file), "picture of what was found, to write");
  options::options_description hidden;
  hidden.add_options()("image", options::value(&arguments->images)->required(), "");
  options::positional_options_description positions;
  positions.add("image", -1);
  if (!parseArguments(argc, argv, visible, hidden, positions)) return false;
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

void print(const MirrorRim& rim) {
  constexpr double kPercent = 100.0;
  std::printf(
      "mirror:\n"
      "  centre_u: %.3f  # [px] +- %.3f\n"
      "  centre_v: %.3f  # [px] +- %.3f\n"
      "# rim: radius %.2f +- %.2f px, seen in %.0f %% of the directions, "
      "its edge within %.2f px (1 sigma)\n"
      "mask:\n"
      "  outer_radius: %.0f.0  # [px] inside the rim\n",
      rim.circle.centre_px.x(), rim.stddev(0), rim.circle.centre_px.y(), rim.stddev(1),
      rim.circle.radius_px, rim.stddev(2), kPercent * rim.visible_part, rim.scatter_px,
      std::floor(rim.circle.radius_px));
}

void find(const Arguments& arguments) {
  const cv::Mat image = meanOf(arguments.images);
  const auto rim = findMirrorRim(image, searchFor(arguments, image));
  if (!rim) {
    throw std::runtime_error(
        "no rim found: a circle about the image's middle must be seen in a third of the directions "
        "(more light, more images of a turning robot, or --radius help)");
  }
  print(*rim);
  if (arguments.output_file.empty()) return;
  if (!cv::imwrite(arguments.output_file, annotateRim(image, *rim))) {
    throw std::runtime_error(arguments.output_file + ": cannot be written");
  }
}

int run(int argc, char** argv) {
  Arguments arguments;
  if (parse(argc, argv, &arguments)) find(arguments);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace bearing_calibration

int main(int argc, char** argv) {
  return bearing_calibration::runProgram("find_mirror",
                                         [&] { return bearing_calibration::run(argc, argv); });
}
