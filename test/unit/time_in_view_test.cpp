// What a driver hears who does not keep the light in a limited field of view.

#include <gtest/gtest.h>

#include <string>

#include "bearing_calibration/judge/driver_advice.h"
#include "support/simulated_calibration.h"

namespace bearing_calibration::core {
namespace {

using testing::calibratorConfig;
using testing::paperRobot;
using testing::play;
using testing::simulate;

const FieldOfView kSixth{0.0, kPi / 3.0};
const char* const kOther = "drive on";

/// Images at 10 Hz, one of so many with the light.
void watch(double duration_s, int one_of, const FieldOfView& view, Stamp* now, TimeInView* time) {
  const int images = static_cast<int>(10.0 * duration_s);
  for (int i = 0; i < images; ++i) {
    *now += durationFromSeconds(0.1);
    time->add(view, *now, one_of > 0 && i % one_of == 0);
  }
}

std::string adviceAfter(double duration_s, int one_of, const FieldOfView& view) {
  Stamp now = stampFromSeconds(1.0);
  TimeInView time;
  watch(duration_s, one_of, view, &now, &time);
  return time.adviceWith(kOther);
}

TEST(TimeInView, SaysHowRarelyTheLightIsSeen) {
  EXPECT_EQ(adviceAfter(200.0, 20, kSixth),
            std::string("the light was in view in 5 % of the last images, and the sensor sees 60 "
                        "deg of a turn: keep it in view; ") +
                kOther);
}

TEST(TimeInView, SaysNothingWhereThereIsNothingToSay) {
  EXPECT_EQ(adviceAfter(200.0, 5, kSixth), kOther) << "a fifth is more than a sixth";
  EXPECT_EQ(adviceAfter(200.0, 20, {}), kOther) << "all around: it is hidden or dark";
  EXPECT_EQ(adviceAfter(5.0, 20, kSixth), kOther) << "too soon";
}

TEST(TimeInView, ForgetsWhatIsLongAgo) {
  Stamp now = stampFromSeconds(1.0);
  TimeInView time;
  watch(300.0, 1, kSixth, &now, &time);
  EXPECT_EQ(time.adviceWith(kOther), kOther);
  watch(60.0, 0, kSixth, &now, &time);  // exp(-3) of it is left
  EXPECT_NE(time.adviceWith(kOther).find("in view in 5 %"), std::string::npos);
  watch(60.0, 1, kSixth, &now, &time);
  EXPECT_EQ(time.adviceWith(kOther), kOther);
}

/// The dance with a camera of 60 deg whose light is hidden half of the time.
TEST(Calibrator, AdvisesToKeepTheLightInView) {
  SimulatedRecord record = simulate(paperRobot(1), 40.0);
  int count = 0;
  for (BearingSet& image : record.bearings) {
    const double off_rad = wrapAngle(image.candidates.front().azimuth_rad - kSixth.centre_rad);
    if (std::abs(off_rad) > 0.5 * kSixth.width_rad || ++count % 2 == 0) image.candidates.clear();
  }
  Calibrator unsaid(calibratorConfig());
  EXPECT_EQ(play(record, &unsaid).advice.find("keep it in view"), std::string::npos);
  for (BearingSet& image : record.bearings) image.view = kSixth;
  Calibrator said(calibratorConfig());
  const std::string advice = play(record, &said).advice;
  EXPECT_EQ(advice.find("the light was in view in "), 0U) << advice;
  EXPECT_NE(advice.find("sees 60 deg of a turn: keep it in view; "), std::string::npos) << advice;
  said.setPaused(true);
  EXPECT_EQ(said.result().advice, adviceFor(CalibrationState::kPaused));
}

/// Two lights in turn, the first one in every eighth image.
TEST(Calibrator, AdvisesNothingWhereAnotherLightIsInView) {
  SimulatedRecord record = simulate(paperRobot(1), 20.0);
  int count = 0;
  for (BearingSet& image : record.bearings) {
    image.candidates.front().light_id = count++ % 8 == 0 ? 1 : 2;
    image.view = kSixth;
  }
  CalibratorConfig config = calibratorConfig();
  config.max_lights = 2;
  Calibrator calibrator(config);
  const CalibrationResult result = play(record, &calibrator);
  EXPECT_NE(result.state, CalibrationState::kConverged);
  EXPECT_EQ(result.advice.find("the light was in view"), std::string::npos) << result.advice;
}

}  // namespace
}  // namespace bearing_calibration::core
