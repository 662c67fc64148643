// Writes a recording in two CSV files as a bag of this package's messages: csv_to_bag --help

#include <boost/program_options.hpp>
#include <fstream>
#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include "bearing_calibration/LightBearings.h"
#include "bearing_calibration/WheelTicks.h"
#include "bearing_calibration/common/formatted.h"
#include "tools/common/command_line.h"
#include "tools/owner/bag_writer.h"
#include "tools/owner/recording_csv.h"

namespace bearing_calibration::core {
namespace {

namespace options = boost::program_options;

struct Arguments {
  std::string odometry_file;
  std::string bearings_file;
  std::string output_file;
  std::int32_t landmark_id = 0;
  RecordingUnits units;
  double bearing_stddev_rad = 0.0;
  std::string sensor_frame;
  std::string ticks_topic;
  std::string bearings_topic;
};

options::options_description describeOptions(Arguments* arguments) {
  options::options_description description(
      "csv_to_bag ODOMETRY.csv BEARINGS.csv --landmark ID --output OUT.bag\n\n"
      "ODOMETRY.csv: t_s,left_m,right_m (rolled since the row before) or\n"
      "              t_s,left_ticks,right_ticks (counts)\n"
      "BEARINGS.csv: t_s,landmark_id,bearing_rad (counter-clockwise, sensor frame)\n"
      "Messages are stamped and recorded at start-time + t_s\n\nOptions");
  // Fine enough that rounding (3 um) is nothing beside a wheel's noise, coarse enough that 32-bit
  // counters hold 20 km.
  constexpr double kDefaultMetersPerTick = 1e-5;
  constexpr double kDefaultStartTime_s = 1e6;  // anything but zero, which means "no stamp" in ROS
  constexpr double kDefaultBearingStddev_rad = 0.02;  // a laser's or a good camera's order
  auto add = description.add_options();
  add("help,h", "print this");
  add("landmark", options::value(&arguments->landmark_id)->required(), "the one to take");
  add("output,o", options::value(&arguments->output_file)->required(), "bag to write");
  add("meters-per-tick",
      options::value(&arguments->units.meters_per_tick)
          ->default_value(kDefaultMetersPerTick, "1e-5"),
      "for columns in metres: their running sum is quantised to this [m]");
  add("start-time",
      options::value(&arguments->units.start_time_s)->default_value(kDefaultStartTime_s, "1000000"),
      "stamp of t_s = 0 [s]");
  add("bearing-stddev",
      options::value(&arguments->bearing_stddev_rad)
          ->default_value(kDefaultBearingStddev_rad, "0.02"),
      "standard deviation of a bearing [rad]");
  add("sensor-frame", options::value(&arguments->sensor_frame)->default_value("camera"),
      "frame_id of the bearings");
  add("ticks-topic", options::value(&arguments->ticks_topic)->default_value("wheel_ticks"), "");
  add("bearings-topic", options::value(&arguments->bearings_topic)->default_value("bearings"), "");
  return description;
}

/// False when only help was asked for. @throws options::error
bool parse(int argc, char** argv, Arguments* arguments) {
  const options::options_description visible = describeOptions(arguments);
  options::options_description hidden;
  hidden.add_options()("odometry", options::value(&arguments->odometry_file)->required(),
                       "ODOMETRY.csv")(
      "bearings", options::value(&arguments->bearings_file)->required(), "BEARINGS.csv");
  options::positional_options_description positions;
  positions.add("odometry", 1).add("bearings", 1);
  if (!parseArguments(argc, argv, visible, hidden, positions)) return false;
  core::requireGreaterThan0("meters-per-tick", arguments->units.meters_per_tick);
  core::requireGreaterThan0("bearing-stddev", arguments->bearing_stddev_rad);
  return true;
}

ros::Time rosTime(Stamp stamp) {
  ros::Time time;
  time.fromNSec(static_cast<std::uint64_t>(stamp.time_since_epoch().count()));
  return time;
}

void write(const CounterRow& row, const Arguments& arguments, BagWriter* bag) {
  WheelTicks message;
  message.header.stamp = rosTime(row.stamp);
  message.left = row.left_ticks;
  message.right = row.right_ticks;
  bag->write(arguments.ticks_topic, message.header.stamp, message);
}

void write(const ObservationRow& row, const Arguments& arguments, BagWriter* bag) {
  constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
  LightBearing candidate;
  candidate.azimuth = row.bearing_rad;
  candidate.azimuth_variance = arguments.bearing_stddev_rad * arguments.bearing_stddev_rad;
  candidate.image_radius = kNotMeasured;
  candidate.image_radius_variance = kNotMeasured;
  candidate.elevation = kNotMeasured;
  candidate.elevation_variance = kNotMeasured;
  candidate.light_id = arguments.landmark_id;
  candidate.probability = 1.0F;
  candidate.track_probability = std::numeric_limits<float>::quiet_NaN();
  LightBearings message;
  message.header.stamp = rosTime(row.stamp);
  message.header.frame_id = arguments.sensor_frame;
  message.candidates.push_back(candidate);
  bag->write(arguments.bearings_topic, message.header.stamp, message);
}

/// Both streams in the order of their stamps, ticks first where they are equal.
void writeBag(const std::vector<CounterRow>& counters,
              const std::vector<ObservationRow>& observations, const Arguments& arguments) {
  BagWriter bag(arguments.output_file);
  auto observation = observations.begin();
  for (const CounterRow& counter : counters) {
    for (; observation != observations.end() && observation->stamp < counter.stamp; ++observation) {
      write(*observation, arguments, &bag);
    }
    write(counter, arguments, &bag);
  }
  for (; observation != observations.end(); ++observation) write(*observation, arguments, &bag);
  bag.finish();
}

std::ifstream open(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file + ": cannot be opened");
  return stream;
}

/// From when to when, in the file's own seconds.
template <typename Row>
std::string timeOf(const std::vector<Row>& rows, const Arguments& arguments) {
  const double start_s = arguments.units.start_time_s;
  return formatted("t_s from %.3f to %.3f",
                   secondsFromDuration(rows.front().stamp.time_since_epoch()) - start_s,
                   secondsFromDuration(rows.back().stamp.time_since_epoch()) - start_s);
}

void convert(const Arguments& arguments) {
  std::ifstream odometry = open(arguments.odometry_file);
  std::ifstream bearings = open(arguments.bearings_file);
  const auto counters = readCounters(odometry, arguments.odometry_file, arguments.units);
  const auto observations =
      readObservations(bearings, arguments.bearings_file, arguments.landmark_id, arguments.units);
  const std::string wheels_time = timeOf(counters, arguments);
  const std::string bearings_time = timeOf(observations, arguments);
  if (counters.back().stamp < observations.front().stamp ||
      observations.back().stamp < counters.front().stamp) {
    throw std::runtime_error("the files have no time in common (" + arguments.odometry_file + ": " +
                             wheels_time + "; " + arguments.bearings_file + ": " + bearings_time +
                             "): one clock, in seconds, is needed");
  }
  writeBag(counters, observations, arguments);
  std::cout << arguments.output_file << ": " << counters.size() << " messages on "
            << arguments.ticks_topic << " (" << wheels_time << "), " << observations.size()
            << " on " << arguments.bearings_topic << " (" << bearings_time << ")\n";
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  using namespace bearing_calibration::core;
  return runProgram("csv_to_bag", argc, argv, parse, convert);
}
