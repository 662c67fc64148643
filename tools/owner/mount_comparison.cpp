#include "tools/owner/mount_comparison.h"

#include <Eigen/LU>
#include <algorithm>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/output/yaml_writer.h"

namespace bearing_calibration::core {
namespace {

/// One set of honest estimates in a hundred is said to disagree.
constexpr double kFalseAlarm = 0.01;

std::string rowOf(const std::string& name, const MountEstimate& mount, int width) {
  const Eigen::Vector3d stddev = mount.covariance.diagonal().cwiseSqrt();
  return formatted("%-*s  %8.4f +- %.4f  %8.4f +- %.4f  %8.4f +- %.4f", width, name.c_str(),
                   mount.mean.x(), stddev.x(), mount.mean.y(), stddev.y(), mount.mean.z(),
                   stddev.z());
}

void writeXYYaw(YamlWriter& write, const char* key, const Eigen::Vector3d& x_y_yaw) {
  const auto numbers = [&](YamlWriter&) {
    write("x", x_y_yaw.x());
    write("y", x_y_yaw.y());
    write("yaw", x_y_yaw.z());
  };
  write.group(key, numbers, true);
}

void writeRow(YamlWriter& write, const std::string& name, const MountEstimate& mount,
              double chi_square) {
  write("name", name);
  writeXYYaw(write, "base_from_camera", mount.mean);
  writeXYYaw(write, "stddev", mount.covariance.diagonal().cwiseSqrt());
  write("chi_square", chi_square);
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
    weighted += weight * mountDifference(each.mount.mean, origin);
  }
  MountComparison comparison;
  comparison.together.covariance = information.inverse();
  comparison.together.mean = origin + comparison.together.covariance * weighted;
  comparison.together.mean.z() = wrapAngle(comparison.together.mean.z());
  for (const NamedMount& each : mounts) {
    const Eigen::Vector3d difference = mountDifference(each.mount.mean, comparison.together.mean);
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
  std::string text = formatted("%-*s  %-18s  %-18s  %-18s  %s\n", columns, "", "       x [m]",
                               "       y [m]", "     yaw [rad]", "chi-square");
  for (std::size_t i = 0; i < mounts.size(); ++i) {
    text += rowOf(mounts[i].name, mounts[i].mount, columns) +
            formatted("  %8.1f\n", comparison.shares[i]);
  }
  text +=
      rowOf(together, comparison.together, columns) + formatted("  %8.1f\n", comparison.chi_square);
  text += formatted("Chi-square %.1f with %d degrees of freedom, p = %.2g: ", comparison.chi_square,
                    comparison.degrees_of_freedom, comparison.p_value);
  return text + (comparison.agrees()
                     ? "they agree.\n"
                     : "they DISAGREE by more than their standard deviations say.\n");
}

std::string toYaml(const std::vector<NamedMount>& mounts, const MountComparison& comparison) {
  YamlWriter write;
  write.out << YAML::Comment("Several estimates of one mount; m and rad.") << YAML::BeginMap;
  write("agrees", comparison.agrees());
  write("p_value", comparison.p_value);
  write("degrees_of_freedom", comparison.degrees_of_freedom);
  write.group("together", [&](YamlWriter&) {
    writeRow(write, "together", comparison.together, comparison.chi_square);
  });
  auto share = comparison.shares.begin();
  write.list("mounts", mounts, [&](const NamedMount& each) {
    write.out << YAML::BeginMap;
    writeRow(write, each.name, each.mount, *share++);
    write.out << YAML::EndMap;
  });
  write.out << YAML::EndMap;
  return std::string(write.out.c_str()) + "\n";
}

}  // namespace bearing_calibration::core
