#include "tools/owner/bag_files.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <sstream>
#include <utility>

#include "bearing_calibration/output/result_file.h"
#include "bearing_calibration_ros/result_messages.h"
#include "bearing_calibration_ros/result_saver.h"

namespace bearing_calibration::core {
namespace {

/// Empty where there is no such value.
std::string cell(double value) { return std::isfinite(value) ? shortestText(value) : ""; }

double secondsSince(Stamp start, Stamp stamp) { return secondsFromDuration(stamp - start); }

std::string estimatesCsv(const BagOutcome& outcome, Stamp start) {
  std::ostringstream csv;
  csv << "t_s,distance_m,state,x_m,y_m,yaw_rad,x_stddev_m,y_stddev_m,yaw_stddev_rad\n";
  for (const EstimateRow& row : outcome.history) {
    const Eigen::Vector3d stddev = row.mount.covariance.diagonal().cwiseSqrt();
    csv << cell(secondsSince(start, row.stamp)) << ',' << cell(row.distance_m) << ','
        << nameOf(row.state);
    for (int i = 0; i < 3; ++i) csv << ',' << cell(row.mount.mean(i));
    for (int i = 0; i < 3; ++i) csv << ',' << cell(stddev(i));
    csv << '\n';
  }
  return csv.str();
}

std::string plansCsv(const BagOutcome& outcome, Stamp start) {
  std::ostringstream csv;
  csv << "t_s,x_stddev_m,y_stddev_m,yaw_stddev_rad\n";
  for (const PlanRow& row : outcome.plans) {
    csv << cell(secondsSince(start, row.stamp));
    for (int i = 0; i < 3; ++i) csv << ',' << cell(row.stddev(i));
    csv << '\n';
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
    csv << cell(secondsSince(start, observation.stamp)) << ',' << cell(reviewed.distance_m) << ','
        << cell(base.position_m.x()) << ',' << cell(base.position_m.y()) << ','
        << cell(base.yaw_rad) << ',' << nameOf(reviewed.outcome.kind) << ','
        << nameOf(reviewed.verdict) << ',' << cell(observation.azimuth_rad) << ','
        << cell(std::sqrt(observation.azimuth_variance_rad2)) << ',' << cell(reviewed.residual_rad)
        << ',' << cell(reviewed.nis) << '\n';
  }
  return csv.str();
}

template <typename Value>
void emit(YAML::Emitter& out, const char* key, const Value& value) {
  out << YAML::Key << key << YAML::Value << value;
}

void emit(YAML::Emitter& out, const char* key, double value) {
  out << YAML::Key << key << YAML::Value << shortestText(value);
}

void beginGroup(YAML::Emitter& out, const char* key) {
  out << YAML::Key << key << YAML::Value << YAML::BeginMap;
}

/// Where the first light stood, in the base's frame at the first image.
void emitLight(YAML::Emitter& out, const BagOutcome& outcome) {
  const std::vector<LightSummary>& lights = outcome.result.lights;
  if (lights.empty() || !lights.front().cartesian_state || outcome.review.images.empty()) return;
  const Eigen::Vector2d light =
      outcome.review.images.back().first_from_base * lights.front().cartesian_state->lightInBase();
  beginGroup(out, "light_in_first_base");
  emit(out, "x", light.x());
  emit(out, "y", light.y());
  out << YAML::EndMap;
}

void emitReview(YAML::Emitter& out, const BagOutcome& outcome) {
  const Review& review = outcome.review;
  emit(out, "has_estimate", outcome.result.cartesian_state.has_value());
  emit(out, "settled", review.settled);
  emit(out, "bearing_correlation", review.correlation);
  emit(out, "slips", review.slips);
  emit(out, "sensor", inWords(review.sensor));
  beginGroup(out, "motion");
  emit(out, "path_m", review.motion.path_m);
  emit(out, "turn_rad", review.motion.turn_rad);
  emit(out, "extent_m", review.motion.extent_m);
  emit(out, "second_curvature_m", review.motion.second_curvature_m);
  out << YAML::EndMap;
  emitLight(out, outcome);
}

std::string detailsYaml(const BagJob& job, const BagSetup& setup, const BagOutcome& outcome) {
  const CalibratorConfig& config = setup.calibration.calibrator;
  YAML::Emitter out;
  out << YAML::Comment("What the report says beside result.yaml; m and rad.") << YAML::BeginMap;
  emit(out, "name", job.name);
  emit(out, "bag", job.bag);
  emit(out, "wheels_topic", outcome.topics.wheels);
  emit(out, "bearings_topic", outcome.topics.observations());
  emit(out, "images", outcome.images);
  emit(out, "state", nameOf(outcome.result.state));
  emit(out, "advice", outcome.result.advice);
  emit(out, "rejections", bearing_calibration_ros::rejectionsText(outcome.result, 0));
  emit(out, "warnings", outcome.warnings);
  emitReview(out, outcome);
  beginGroup(out, "settings");
  emit(out, "position_stddev_target_m", config.converged.position_stddev_m);
  emit(out, "yaw_stddev_target_rad", config.converged.yaw_stddev_rad);
  emit(out, "gate_probability", config.filter.gate_probability);
  emit(out, "wheel_separation_m", config.drive.wheel_separation_m);
  out << YAML::EndMap << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
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
