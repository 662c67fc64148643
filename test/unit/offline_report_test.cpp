#include "bearing_calibration/output/offline_report.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/common/chi_square.h"
#include "support/simulated_calibration.h"

namespace bearing_calibration::core {
namespace {

using testing::calibratorConfig;
using testing::mountChiSquare;
using testing::paperRobot;
using testing::play;
using testing::simulate;

constexpr double kDuration_s = 60.0;

/// A record that went through a calibrator, with its review.
struct Reviewed {
  explicit Reviewed(const SimulatedRecord& record, double to_s = kDuration_s) {
    Calibrator calibrator(calibratorConfig());
    OfflineReport looked(calibratorConfig().initializer);
    calibrator.observe([&](const AssociationOutcome& outcome) { looked.add(outcome); });
    result = play(record, &calibrator, {0.0}, 0.0, to_s);
    review = looked.conclude(result);
  }

  CalibrationResult result;
  Review review;
};

TEST(OfflineReport, JudgesEveryImage) {
  const SimulatedRecord record = simulate(paperRobot(3), kDuration_s);
  const Reviewed reviewed(record);
  int used = 0;
  double nis_sum = 0.0;
  for (const ReviewedImage& image : reviewed.review.images) {
    if (image.verdict != Verdict::kUsed) continue;
    ++used;
    nis_sum += image.nis;
    EXPECT_LT(std::abs(image.residual_rad),
              6.0 * std::sqrt(image.outcome.observation.azimuth_variance_rad2));
  }
  EXPECT_EQ(reviewed.review.images.size(), reviewed.result.bearing_inputs[InputStatus::kAccepted]);
  EXPECT_GT(used, 0.95 * static_cast<double>(reviewed.review.images.size()));
  EXPECT_NEAR(nis_sum / used, 1.0, 5.0 * std::sqrt(2.0 / used));
}

TEST(OfflineReport, MarksAnOutlier) {
  SimulatedRecord record = simulate(paperRobot(4), kDuration_s);
  const std::size_t false_one = record.bearings.size() / 2;
  record.bearings[false_one].candidates.front().azimuth_rad += 1.0;
  const Stamp stamp = record.bearings[false_one].stamp;
  const Reviewed reviewed(record);
  bool found = false;
  for (const ReviewedImage& image : reviewed.review.images) {
    if (image.outcome.observation.stamp != stamp) continue;
    found = true;
    EXPECT_EQ(image.verdict, Verdict::kLeftOut);
    EXPECT_NEAR(image.residual_rad, 1.0, 0.1);
    EXPECT_TRUE(std::isnan(image.nis));
  }
  EXPECT_TRUE(found);
}

TEST(OfflineReport, WithoutAnEstimateNothingIsJudged) {
  constexpr double kTooShort_s = 3.0;  // one straight line
  const Reviewed reviewed(simulate(paperRobot(5), kDuration_s), kTooShort_s);
  EXPECT_FALSE(reviewed.review.settled);
  ASSERT_FALSE(reviewed.review.images.empty());
  for (const ReviewedImage& image : reviewed.review.images) {
    EXPECT_EQ(image.verdict, Verdict::kUnjudged);
    EXPECT_TRUE(std::isnan(image.residual_rad));
  }
}

TEST(OfflineReport, ALostLightStartsItAnew) {
  OfflineReport review(calibratorConfig().initializer);
  AssociationOutcome outcome;
  outcome.kind = Association::Kind::kFound;
  outcome.observation.azimuth_variance_rad2 = 1e-4;
  for (int i = 0; i < 3; ++i) {
    outcome.observation.stamp = stampFromSeconds(1.0 + i);
    outcome.lost_light = i == 2;
    review.add(outcome);
  }
  EXPECT_EQ(review.conclude({}).images.size(), 1U);
}

}  // namespace
}  // namespace bearing_calibration::core
