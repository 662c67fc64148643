#include "tools/owner/calibrate_bag_arguments.h"

#include <algorithm>
#include <boost/program_options.hpp>
#include <thread>

#include "tools/common/command_line.h"

namespace bearing_calibration::core {
namespace {

namespace options = boost::program_options;

constexpr char kUsage[] =
    "calibrate_bag BAG... --output DIR [--config FILE] [--set NAME=VALUE] [options]\n\n"
    "Finds the mount of the bearing sensor in each bag, without a ROS master. Writes into DIR "
    "(with\n"
    "several bags or lights: into a folder for each) result.yaml, the URDF joint and the like, "
    "and\n"
    "what calibration_report makes its report from. A better result of the same mount that lies\n"
    "there stays, and beside others' files the subfolder bearing_calibration is used.\n\n"
    "Exit status: 0 converged; 1 failed; 2 wrong arguments or parameters; 3 the mount is not\n"
    "observable with this motion; 4 found, but CONVERGING; 5 the estimates disagree\n"
    "(--compare).\n"
    "With several bags it is the first of 1, 3, 5, 4 that holds for one of them.\n\nOptions";

options::options_description describeOptions(CalibrateBagArguments* arguments) {
  options::options_description description(kUsage);
  auto add = description.add_options();
  add("help,h", "print this");
  add("output,o", options::value(&arguments->output_folder)->required(), "folder of the results");
  add("config,c", options::value(&arguments->config_files)->composing(),
      "your robot's numbers, and what else differs from config/calibration.yaml and "
      "config/detection.yaml, which the live nodes read; may be repeated");
  add("set", options::value(&arguments->assignments)->composing(),
      "a single one, such as wheels/separation=0.40; may be repeated");
  add("compare", options::bool_switch(&arguments->compare),
      "show all estimates side by side and test whether they agree");
  add("light", options::value(&arguments->light_ids)->composing(),
      "use the light of this id only, where the sensor distinguishes lights; may be repeated");
  add("each-light", options::bool_switch(&arguments->each_light),
      "one calibration for each light of a bag");
  add("wheels-topic", options::value(&arguments->topics.wheels),
      "default: the bag's only one of WheelTicks, or by wheels/source JointState or Odometry; with "
      "separate ticks the left wheel's, left_ticks");
  add("right-wheel-topic", options::value(&arguments->topics.right_wheel),
      "with separate ticks the right wheel's, default: right_ticks");
  add("bearings-topic", options::value(&arguments->topics.bearings),
      "default: the bag's only one of LightBearings");
  add("image-topic", options::value(&arguments->topics.images),
      "images to find the light in; default: the bag's only one, where it holds no bearings");
  add("jobs,j", options::value(&arguments->jobs)->default_value(0),
      "bags at a time; 0: a core each");
  add("quiet,q", options::bool_switch(&arguments->quiet), "no progress bar");
  return description;
}

void check(CalibrateBagArguments* arguments) {
  if (arguments->jobs < 0) throw options::error("--jobs must not be negative");
  if (arguments->each_light && !arguments->light_ids.empty()) {
    throw options::error("--each-light and --light exclude each other");
  }
  if (!arguments->topics.bearings.empty() && !arguments->topics.images.empty()) {
    throw options::error("--bearings-topic and --image-topic exclude each other");
  }
  if (arguments->jobs == 0) {
    arguments->jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  }
}

}  // namespace

std::optional<CalibrateBagArguments> parseCalibrateBagArguments(int argc, char** argv) {
  CalibrateBagArguments arguments;
  const options::options_description visible = describeOptions(&arguments);
  options::options_description hidden;
  hidden.add_options()("bag", options::value(&arguments.bags)->required(), "BAG");
  options::positional_options_description positions;
  positions.add("bag", -1);
  if (!parseArguments(argc, argv, visible, hidden, positions)) return std::nullopt;
  check(&arguments);
  return arguments;
}

}  // namespace bearing_calibration::core
