#include "bearing_calibration_ros/input_watch.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "bearing_calibration_ros/guarded_nodelet.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;

const core::InputOutcome kGood{core::InputStatus::kAccepted, 0.0};
constexpr double kLimit_s = 1.0;
const core::InputOutcome kLate{core::InputStatus::kStampNotAfterLast, 2.0};

TEST(ClockWatch, NoticesAJumpBackOnce) {
  ClockWatch watch;
  EXPECT_FALSE(watch.hasJumpedBack(ros::Time(100.0), kLimit_s));
  EXPECT_FALSE(watch.hasJumpedBack(ros::Time(101.0), kLimit_s));
  EXPECT_FALSE(watch.hasJumpedBack(ros::Time(100.95), kLimit_s)) << "a jitter";
  EXPECT_FALSE(watch.hasJumpedBack(ros::Time(100.1), kLimit_s)) << "network time";
  EXPECT_TRUE(watch.hasJumpedBack(ros::Time(98.0), kLimit_s)) << "a bag of three seconds";
  EXPECT_FALSE(watch.hasJumpedBack(ros::Time(98.0), kLimit_s));
  EXPECT_FALSE(watch.hasJumpedBack(ros::Time(200.0), kLimit_s)) << "a jump ahead is a pause";
}

TEST(ClockWatch, SmallStepsBackDoNotAddUpUnseen) {
  ClockWatch watch;
  EXPECT_FALSE(watch.hasJumpedBack(ros::Time(100.0), kLimit_s));
  EXPECT_FALSE(watch.hasJumpedBack(ros::Time(99.4), kLimit_s));
  EXPECT_TRUE(watch.hasJumpedBack(ros::Time(98.8), kLimit_s));
}

/// How many late readings in a row it takes.
int lateReadingsUntilNoticed(StampWatch* watch, std::int64_t step_ns) {
  for (int count = 1; count < 1000; ++count) {
    if (watch->hasBegunAnew(kLate, core::stampFromNanoseconds(1000 + count * step_ns), kLimit_s)) {
      return count;
    }
  }
  return -1;
}

TEST(StampWatch, NoticesAStreamThatHasBegunAnew) {
  StampWatch watch;
  EXPECT_EQ(lateReadingsUntilNoticed(&watch, 10), 20);
  EXPECT_EQ(lateReadingsUntilNoticed(&watch, 10), 20) << "and again";
}

TEST(StampWatch, IsNotFooledByLateOrRepeatedReadings) {
  StampWatch watch;
  EXPECT_EQ(lateReadingsUntilNoticed(&watch, 0), -1) << "one reading repeated";
  EXPECT_EQ(lateReadingsUntilNoticed(&watch, -1), -1) << "readings in reverse order";
  for (int i = 0; i < 1000; ++i) {  // two publishers on one topic, one behind the other
    EXPECT_FALSE(watch.hasBegunAnew(kLate, core::stampFromNanoseconds(1000 + i), kLimit_s));
    EXPECT_FALSE(watch.hasBegunAnew(kGood, core::stampFromNanoseconds(2000 + i), kLimit_s));
  }
}

/// Whether a stream at 100 Hz that has stepped back is said to have begun anew before it overtakes.
bool beginsAnewAfter(double step_back_s) {
  StampWatch watch;
  bool has_begun_anew = false;
  for (double behind_s = step_back_s; behind_s >= 0.0; behind_s -= 0.01) {
    const core::InputOutcome late{core::InputStatus::kStampNotAfterLast, behind_s};
    has_begun_anew |= watch.hasBegunAnew(late, core::stampFromSeconds(1000.0 - behind_s), kLimit_s);
  }
  return has_begun_anew;
}

TEST(StampWatch, LivesThroughSmallSteps) {
  EXPECT_FALSE(beginsAnewAfter(0.2));
  EXPECT_FALSE(beginsAnewAfter(0.99));
  EXPECT_TRUE(beginsAnewAfter(1.01)) << "though it is less when that is certain";
  EXPECT_TRUE(beginsAnewAfter(3.0)) << "a bag of three seconds";
}

TEST(InputWatch, NamesTheSilentInput) {
  InputWatch watch("/ticks", "/lights", 5.0);
  EXPECT_EQ(watch.silence(ros::Time(100.0)), "") << "it has only just begun";
  EXPECT_EQ(watch.silence(ros::Time(105.0)), "");
  EXPECT_EQ(watch.silence(ros::Time(106.0)),
            "no input: nothing has come on /ticks yet, nothing has come on /lights yet");
  watch.sawWheels(ros::Time(110.0));
  EXPECT_EQ(watch.silence(ros::Time(111.0)),
            "wheel readings without bearings: nothing has come on /lights yet");
  watch.sawBearings(ros::Time(112.0));
  EXPECT_EQ(watch.silence(ros::Time(112.0)), "");
  watch.sawBearings(ros::Time(120.0));
  EXPECT_EQ(watch.silence(ros::Time(120.0)),
            "bearings without wheel readings: nothing has come on /ticks for 10 s");
}

TEST(InputWatch, BeginsAnewWithTheClock) {
  InputWatch watch("/ticks", "/lights", 5.0);
  watch.silence(ros::Time(100.0));
  watch.sawWheels(ros::Time(100.0));
  watch.restart();
  EXPECT_FALSE(watch.areWheelsAlive(ros::Time(1.0)));
  EXPECT_EQ(watch.silence(ros::Time(1.0)), "");
  EXPECT_NE(watch.silence(ros::Time(7.0)), "");
}

TEST(SilenceWatch, KnowsTheRateOfWhatItWatches) {
  SilenceWatch watch;
  EXPECT_TRUE(watch.isSilent(0.0));
  for (const double now_s : {0.0, 2.0, 4.0, 4.1, 8.0}) watch.saw(now_s);  // one is late, one early
  EXPECT_FALSE(watch.isSilent(13.0));
  EXPECT_TRUE(watch.isSilent(30.0));
  double now_s = 100.0;
  for (int i = 0; i < 20; ++i) watch.saw(now_s += 0.1);  // after a pause, at ten times the rate
  EXPECT_FALSE(watch.isSilent(now_s + 1.0));
  EXPECT_TRUE(watch.isSilent(now_s + 3.0));
}

// Promise alive: an exception of any kind in a callback
TEST(ThrownBy, HasWordsForWhateverEndsACallback) {
  EXPECT_EQ(thrownBy([] {}), "");
  EXPECT_EQ(thrownBy([] { throw std::invalid_argument("a broken contract"); }),
            "a broken contract");
  EXPECT_EQ(thrownBy([] { throw XmlRpc::XmlRpcException("type error"); }), "type error");
  EXPECT_NE(thrownBy([] { throw std::runtime_error(""); }), "");
  EXPECT_NE(thrownBy([] { throw 7; }), "");
}

/// A nodelet without a master.
struct ANodelet : GuardedNodelet {
  void start() override {}
  using GuardedNodelet::endCallbacks;
  using GuardedNodelet::guarded;
};

// Promise alive: a nodelet that is deleted during a callback
TEST(GuardedNodelet, WaitsAtItsEndForTheCallbackThatRunsAndLetsNoOtherBegin) {
  ANodelet nodelet;
  std::atomic<bool> has_begun{false};
  std::atomic<bool> is_done{false};
  std::thread manager([&] {
    nodelet.guarded("callback", [&] {
      has_begun = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      is_done = true;
    });
  });
  while (!has_begun) std::this_thread::yield();
  nodelet.endCallbacks();
  EXPECT_TRUE(is_done);
  manager.join();
  EXPECT_NE(nodelet.guarded("late", [] { FAIL() << "begun after the end"; }), "");
}

TEST(LogThrottle, KnowsKindsApart) {
  LogThrottle throttle(5.0);
  EXPECT_TRUE(throttle.isDue("a", ros::SteadyTime(10.0)));
  EXPECT_TRUE(throttle.isDue("b", ros::SteadyTime(11.0)));
  EXPECT_FALSE(throttle.isDue("a", ros::SteadyTime(14.0)));
  EXPECT_TRUE(throttle.isDue("a", ros::SteadyTime(15.0)));
  EXPECT_FALSE(throttle.isDue("b", ros::SteadyTime(15.0)));
}

}  // namespace
}  // namespace bearing_calibration_ros
