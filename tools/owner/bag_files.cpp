#include "tools/owner/bag_files.h"

#include <cmath>
#include <sstream>
#include <utility>

#include "bearing_calibration/output/yaml_writer.h"
#include "bearing_calibration_ros/result_messages.h"
#include "bearing_calibration_ros/result_saver.h"

namespace bearing_calibration::core {
namespace {

/// Cells of a table, empty where there is no such value.
std::string cells(const std::vector<double>& values) {
  std::string row;
  for (double value : values) row += "," + (std::isfinite(value) ? shortestText(value) : "");
  return row.substr(1);
}

double secondsSince(Stamp start, Stamp stamp) { return secondsFromDuration(stamp - start); }

std::string estimatesCsv(const BagOutcome& outcome, Stamp start) {
  std::ostringstream csv;
  csv << "t_s,distance_m,state,x_m,y_m,yaw_rad,x_stddev_m,y_stddev_m,yaw_stddev_rad\n";
  for (const EstimateRow& row : outcome.history) {
    const Eigen::Vector3d& mean = row.mount.mean;
    const Eigen::Vector3d stddev = row.mount.covariance.diagonal().cwiseSqrt();
    csv << cells({secondsSince(start, row.stamp), row.distance_m}) << ',' << nameOf(row.state)
        << ',' << cells({mean.x(), mean.y(), mean.z(), stddev.x(), stddev.y(), stddev.z()}) << '\n';
  }
  return csv.str();
}

std::string plansCsv(const BagOutcome& outcome, Stamp start) {
  std::ostringstream csv;
  csv << "t_s,x_stddev_m,y_stddev_m,yaw_stddev_rad\n";
  for (const PlanRow& row : outcome.plans) {
    csv << cells({secondsSince(start, row.stamp), row.stddev.x(), row.stddev.y(), row.stddev.z()})
        << '\n';
  }
  return csv.str();
}

const char* nameOf(Association::Kind kind) {
  switch (kind) {
    case Association::Kind::kNothingSeen:
      return "nothing seen";
    case Association::Kind::kFound:
      return "taken";
    case Association::Kind::kGated:
      return "gated";
    case Association::Kind::kAmbiguous:
      return "ambiguous";
  }
  return "";
}

std::string imagesCsv(const Review& review, Stamp start) {
  std::ostringstream csv;
  csv << "t_s,distance_m,base_x_m,base_y_m,base_yaw_rad,live,fit,azimuth_rad,"
         "azimuth_stddev_rad,residual_rad,nis\n";
  for (const ReviewedImage& reviewed : review.images) {
    const Observation& observation = reviewed.outcome.observation;
    const Pose2& base = reviewed.first_from_base;
    csv << cells({secondsSince(start, observation.stamp), reviewed.distance_m, base.position_m.x(),
                  base.position_m.y(), base.yaw_rad})
        << ',' << nameOf(reviewed.outcome.kind) << ',' << nameOf(reviewed.verdict) << ','
        << cells({observation.azimuth_rad, std::sqrt(observation.azimuth_variance_rad2),
                  reviewed.residual_rad, reviewed.nis})
        << '\n';
  }
  return csv.str();
}

/// Where the first light stood, in the base's frame at the first image.
void writeLight(YamlWriter& write, const BagOutcome& outcome) {
  const std::vector<LightSummary>& lights = outcome.result.lights;
  if (lights.empty() || !lights.front().cartesian_state || outcome.review.images.empty()) return;
  const Eigen::Vector2d light =
      outcome.review.images.back().first_from_base * lights.front().cartesian_state->lightInBase();
  write.group("light_in_first_base", [&](YamlWriter&) {
    write("x", light.x());
    write("y", light.y());
  });
}

void writeReview(YamlWriter& write, const BagOutcome& outcome) {
  const Review& review = outcome.review;
  write("has_estimate", outcome.result.cartesian_state.has_value());
  write("settled", review.settled);
  write("bearing_correlation", review.correlation);
  write("slips", review.slips);
  write("sensor", inWords(review.sensor));
  write.group("motion", [&](YamlWriter&) {
    write("path_m", review.motion.path_m);
    write("turn_rad", review.motion.turn_rad);
    write("extent_m", review.motion.extent_m);
    write("second_curvature_m", review.motion.second_curvature_m);
  });
  writeLight(write, outcome);
}

std::string detailsYaml(const BagJob& job, const BagSetup& setup, const BagOutcome& outcome) {
  const CalibratorConfig& config = setup.calibration.calibrator;
  YamlWriter write;
  write.out << YAML::Comment("What the report says beside result.yaml; m and rad.")
            << YAML::BeginMap;
  write("name", job.name);
  write("bag", job.bag);
  write("wheels_topic", outcome.topics.wheels);
  write("bearings_topic", outcome.topics.observations());
  write("state", outcome.result.state);
  write("advice", outcome.result.advice);
  write("rejections", bearing_calibration_ros::rejectionsText(outcome.result, 0));
  write("warnings", outcome.warnings);
  writeReview(write, outcome);
  write.group("settings", [&](YamlWriter&) {
    write("position_stddev_target_m", config.converged.position_stddev_m);
    write("yaw_stddev_target_rad", config.converged.yaw_stddev_rad);
    write("wheel_separation_m", config.drive.wheel_separation_m);
  });
  write.out << YAML::EndMap;
  return std::string(write.out.c_str()) + "\n";
}

}  // namespace

StoredResult storeBagFiles(const std::string& folder, const BagJob& job, const BagSetup& setup,
                           const BagOutcome& outcome) {
  const auto& looks = outcome.review.images;
  const Stamp start = looks.empty() ? Stamp() : looks.front().outcome.observation.stamp;
  std::vector<FileText> files = {{"details.yaml", detailsYaml(job, setup, outcome)},
                                 {"estimates.csv", estimatesCsv(outcome, start)},
                                 {"images.csv", imagesCsv(outcome.review, start)},
                                 {"plans.csv", plansCsv(outcome, start)}};
  if (!outcome.optics.empty()) files.push_back({"optics.yaml", outcome.optics});
  const auto saved = bearing_calibration_ros::savedFrom(
      outcome.result, setup.calibration, "calibrate_bag",
      job.bag + ": " + outcome.topics.wheels + ", " + outcome.topics.observations());
  if (!saved) return storeWithoutResult(folder, files);
  SavingTerms terms;
  terms.targets = setup.calibration.calibrator.converged;
  terms.even_if_worse = true;
  terms.more = std::move(files);
  return storeResult(folder, *saved, terms);
}

}  // namespace bearing_calibration::core
