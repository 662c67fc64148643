#include "tools/owner/mount_comparison.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/output/result_file.h"

namespace bearing_calibration::core {
namespace {

/// One set of honest estimates in a hundred is said to disagree.
constexpr double kFalseAlarm = 0.01;

Eigen::Vector3d minus(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  Eigen::Vector3d difference = a - b;
  difference.z() = wrapAngle(difference.z());
  return difference;
}

template <typename... Values>
std::string printed(const char* format, Values... values) {
  char text[200];  // longer than any line of the table
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

std::string rowOf(const std::string& name, const MountEstimate& mount, int width) {
  const Eigen::Vector3d stddev = mount.covariance.diagonal().cwiseSqrt();
  return printed("%-*s  %8.4f +- %.4f  %8.4f +- %.4f  %8.4f +- %.4f", width, name.c_str(),
                 mount.mean.x(), stddev.x(), mount.mean.y(), stddev.y(), mount.mean.z(),
                 stddev.z());
}

void emitXYYaw(YAML::Emitter& out, const char* key, const Eigen::Vector3d& x_y_yaw) {
  out << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginMap;
  out << YAML::Key << "x" << YAML::Value << shortestText(x_y_yaw.x());
  out << YAML::Key << "y" << YAML::Value << shortestText(x_y_yaw.y());
  out << YAML::Key << "yaw" << YAML::Value << shortestText(x_y_yaw.z()) << YAML::EndMap;
}

void emitRow(YAML::Emitter& out, const std::string& name, const MountEstimate& mount,
             double chi_square) {
  out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << name;
  emitXYYaw(out, "base_from_camera", mount.mean);
  emitXYYaw(out, "stddev", mount.covariance.diagonal().cwiseSqrt());
  out << YAML::Key << "chi_square" << YAML::Value << shortestText(chi_square) << YAML::EndMap;
}

}  // namespace

bool MountComparison::agrees() const { return p_value >= kFalseAlarm; }

MountComparison compareMounts(const std::vector<NamedMount>& mounts) {
  if (mounts.size() < 2) throw std::invalid_argument("a comparison needs at least two mounts");
  const Eigen::Vector3d& origin = mounts.front().mount.mean;  // yaw is averaged about it
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
  for (const NamedMount& each : mounts) {
    const Eigen::Matrix3d weight = each.mount.covariance.inverse();
    information += weight;
    weighted += weight * minus(each.mount.mean, origin);
  }
  MountComparison comparison;
  comparison.together.covariance = information.inverse();
  comparison.together.mean = origin + comparison.together.covariance * weighted;
  comparison.together.mean.z() = wrapAngle(comparison.together.mean.z());
  for (const NamedMount& each : mounts) {
    const Eigen::Vector3d difference = minus(each.mount.mean, comparison.together.mean);
    comparison.shares.push_back(difference.dot(each.mount.covariance.inverse() * difference));
    comparison.chi_square += comparison.shares.back();
  }
  comparison.degrees_of_freedom = 3 * (static_cast<int>(mounts.size()) - 1);
  comparison.p_value =
      1.0 - chiSquareProbability(comparison.chi_square, comparison.degrees_of_freedom);
  return comparison;
}

std::string format(const std::vector<NamedMount>& mounts, const MountComparison& comparison) {
  const std::string together = "together";
  std::size_t width = together.size();
  for (const NamedMount& each : mounts) width = std::max(width, each.name.size());
  const int columns = static_cast<int>(width);
  std::string text = printed("%-*s  %-18s  %-18s  %-18s  %s\n", columns, "", "       x [m]",
                             "       y [m]", "     yaw [rad]", "chi-square");
  for (std::size_t i = 0; i < mounts.size(); ++i) {
    text += rowOf(mounts[i].name, mounts[i].mount, columns) +
            printed("  %8.1f\n", comparison.shares[i]);
  }
  text +=
      rowOf(together, comparison.together, columns) + printed("  %8.1f\n", comparison.chi_square);
  text += printed("Chi-square %.1f with %d degrees of freedom, p = %.2g: ", comparison.chi_square,
                  comparison.degrees_of_freedom, comparison.p_value);
  return text + (comparison.agrees()
                     ? "they agree.\n"
                     : "they DISAGREE by more than their standard deviations say.\n");
}

std::string toYaml(const std::vector<NamedMount>& mounts, const MountComparison& comparison) {
  YAML::Emitter out;
  out << YAML::Comment("Several estimates of one mount; m and rad.") << YAML::BeginMap;
  out << YAML::Key << "agrees" << YAML::Value << comparison.agrees();
  out << YAML::Key << "p_value" << YAML::Value << shortestText(comparison.p_value);
  out << YAML::Key << "degrees_of_freedom" << YAML::Value << comparison.degrees_of_freedom;
  out << YAML::Key << "together" << YAML::Value;
  emitRow(out, "together", comparison.together, comparison.chi_square);
  out << YAML::Key << "mounts" << YAML::Value << YAML::BeginSeq;
  for (std::size_t i = 0; i < mounts.size(); ++i) {
    emitRow(out, mounts[i].name, mounts[i].mount, comparison.shares[i]);
  }
  out << YAML::EndSeq << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

}  // namespace bearing_calibration::core
