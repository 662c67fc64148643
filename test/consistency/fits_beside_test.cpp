// Fits on a thread of their own: the same verdict, nothing lost, nothing taken over that no longer
// holds, and callbacks that cost what the filter does.

#include "bearing_calibration/calibration/fits_beside.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <ctime>
#include <functional>
#include <stdexcept>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/judge/fault_finder.h"
#include "support/simulated_calibration.h"
#include "tools/study/draws.h"
#include "tools/study/lights_case.h"

namespace bearing_calibration::core {
namespace {

using std::chrono::steady_clock;
using testing::calibratorConfig;

constexpr std::chrono::minutes kDeadline{5};  // of what hangs

/// A robot's drive with `lights` lights that the sensor tells apart.
/// @param turned_rad  further than the sensor usually is
SimulatedRecord danceWith(int lights, double duration_s, std::uint64_t seed = 3,
                          double turned_rad = 0.0) {
  SimulatedCase simulated = paperCase(seed);
  simulated.robot.base_from_sensor.yaw_rad += turned_rad;
  addLights(simulated, lights, seed);
  simulated.robot.sensor.identifies_lights = true;
  simulated.duration_s = duration_s;
  return simulate(simulated).record;
}

CalibratorConfig configFor(int lights) {
  CalibratorConfig config = calibratorConfig();
  config.max_lights = lights;
  return config;
}

void waitFor(const std::function<bool()>& condition) {
  const auto deadline = steady_clock::now() + kDeadline;
  while (!condition()) {
    ASSERT_LT(steady_clock::now(), deadline);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

/// CPU time of a thread.
double cpuSeconds(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  constexpr double kNanosecond_s = 1e-9;
  return static_cast<double>(time.tv_sec) + kNanosecond_s * static_cast<double>(time.tv_nsec);
}
double ownCpuSeconds() { return cpuSeconds(CLOCK_THREAD_CPUTIME_ID); }

/// Feeds a record to a calibrator as it would arrive. A fit may go on for so many images, which is
/// what it takes on a slow machine; then the record waits for it.
class Player {
 public:
  explicit Player(const SimulatedRecord& record) : record_(record) {}

  /// @param goes_on  asked after each input; false ends it
  void play(
      Calibrator* calibrator, const std::function<bool()>& goes_on = [] { return true; }) {
    for (; tick_ < record_.ticks.size(); ++tick_) {
      const Stamp now = record_.ticks[tick_].stamp;
      for (; image_ < record_.bearings.size() && record_.bearings[image_].stamp <= now; ++image_) {
        measure([&] { calibrator->addBearings(record_.bearings[image_], now); });
        letFit(calibrator);
      }
      measure([&] { calibrator->addTicks(record_.ticks[tick_], now); });
      if (!goes_on()) {
        ++tick_;
        return;
      }
    }
    waitFor([&] {
      calibrator->takeOverFit();
      return !calibrator->fits().under_way;
    });
  }

  /// For the calibrator's observer: the input under way has shown an image.
  void seeImage() { ++images_; }
  /// CPU time of the inputs that did.
  double meanOfImages_s() const { return all_s_ / images_; }
  double longestInput_s() const { return longest_s_; }
  double shareWithFit() const { return static_cast<double>(images_with_fit_) / images_; }

 private:
  void measure(const std::function<void()>& input) {
    const int images = images_;
    const double begin_s = ownCpuSeconds();
    input();
    const double took_s = ownCpuSeconds() - begin_s;
    longest_s_ = std::max(longest_s_, took_s);
    if (images_ > images) all_s_ += took_s;
  }

  void letFit(Calibrator* calibrator) {
    constexpr int kImagesOfAFit = 5;
    const FitsReport fits = calibrator->fits();
    images_of_fit_ = fits.under_way && fits.taken == taken_ ? images_of_fit_ + 1 : 0;
    images_with_fit_ += fits.under_way ? 1 : 0;
    taken_ = fits.taken;
    if (images_of_fit_ < kImagesOfAFit) return;
    waitFor([&] {
      calibrator->takeOverFit();
      return calibrator->fits().taken > taken_ || !calibrator->fits().under_way;
    });
    images_of_fit_ = 0;
  }

  const SimulatedRecord& record_;
  std::size_t tick_ = 0;
  std::size_t image_ = 0;
  int images_of_fit_ = 0;
  std::uint32_t taken_ = 0;
  int images_ = 0;
  int images_with_fit_ = 0;
  double all_s_ = 0.0;
  double longest_s_ = 0.0;
};

class FitsBesideWith : public ::testing::TestWithParam<int> {};

TEST_P(FitsBesideWith, EndWithTheVerdictOfFitsAtOnce) {
  const SimulatedRecord record = danceWith(GetParam(), 100.0);
  Calibrator at_once(configFor(GetParam()));
  Calibrator beside(configFor(GetParam()), FitsRun::kBeside);
  std::vector<Stamp> seen;
  beside.observe(
      [&](const AssociationOutcome& outcome) { seen.push_back(outcome.observation.stamp); });
  Player(record).play(&at_once);
  Player(record).play(&beside);
  const CalibrationResult expected = at_once.result();
  const CalibrationResult result = beside.result();
  EXPECT_EQ(expected.state, CalibrationState::kConverged) << expected.advice;
  EXPECT_EQ(result.state, expected.state) << result.advice;
  constexpr double kAlike_sigmas = 0.1;
  const Eigen::Vector3d difference =
      result.base_from_sensor->mean - expected.base_from_sensor->mean;
  const double sigmas =
      std::sqrt(difference.dot(expected.base_from_sensor->covariance.ldlt().solve(difference)));
  std::printf("%d lights: %.4f sigma apart, %u fits taken over\n", GetParam(), sigmas,
              beside.fits().taken);
  EXPECT_LT(sigmas, kAlike_sigmas);
  EXPECT_GT(beside.fits().taken, 0U);
  EXPECT_EQ(at_once.fits().taken, 0U);
  // nothing is lost, and each image is told once
  EXPECT_EQ(result.ticks_used, expected.ticks_used);
  EXPECT_EQ(result.bearings_waiting, expected.bearings_waiting);
  EXPECT_EQ(result.bearings_used + result.bearings_gated,
            expected.bearings_used + expected.bearings_gated);
  std::vector<Stamp> stamps;
  for (const BearingSet& image : record.bearings) stamps.push_back(image.stamp);
  stamps.resize(stamps.size() - result.bearings_waiting);
  EXPECT_EQ(seen, stamps);
}

INSTANTIATE_TEST_SUITE_P(Lights, FitsBesideWith, ::testing::Values(1, 3));

/// What makes a fit that is under way worthless.
struct Interruption {
  const char* name;
  std::function<void(Calibrator*, Stamp now)> happen;
};
void PrintTo(const Interruption& interruption, std::ostream* out) { *out << interruption.name; }

class FitsInterrupted : public ::testing::TestWithParam<Interruption> {};

TEST_P(FitsInterrupted, AreDropped) {
  const SimulatedRecord record = danceWith(1, 60.0);
  Calibrator calibrator(configFor(1), FitsRun::kBeside);
  Player player(record);
  Stamp now;
  calibrator.observe([&](const AssociationOutcome& outcome) { now = outcome.observation.stamp; });
  FitsReport before;
  FitsReport after;
  do {
    const std::uint32_t some_fits = calibrator.fits().taken + 5;
    player.play(&calibrator, [&] {
      return calibrator.fits().taken < some_fits || !calibrator.fits().under_way;
    });
    before = calibrator.fits();
    ASSERT_TRUE(before.under_way);
    GetParam().happen(&calibrator, now);
    after = calibrator.fits();
  } while (after.taken > before.taken);  // it had ended, and an input took it over just before
  EXPECT_EQ(after.dropped, before.dropped + 1);
  waitFor([&] {
    calibrator.takeOverFit();
    return !calibrator.fits().under_way;
  });
  EXPECT_EQ(calibrator.fits().taken, before.taken);
}

/// Readings of a clock that has stepped back.
void stepBack(Calibrator* calibrator, Stamp now) {
  constexpr Duration kPeriod = std::chrono::milliseconds(10);
  constexpr Duration kBack = std::chrono::milliseconds(300);
  for (int i = 0; i < 3; ++i) calibrator->addTicks({now - kBack + i * kPeriod, 0, 0}, now);
}

INSTANTIATE_TEST_SUITE_P(
    By, FitsInterrupted,
    ::testing::Values(
        Interruption{"Reset", [](Calibrator* calibrator, Stamp) { calibrator->reset(); }},
        Interruption{"Pause", [](Calibrator* calibrator, Stamp) { calibrator->setPaused(true); }},
        Interruption{"Clock", stepBack},
        Interruption{"TakeUp", [](Calibrator* calibrator, Stamp) { calibrator->resume({}); }}),
    [](const auto& interruption) { return std::string(interruption.param.name); });

/// For what does not ask how good the fits are: when a record is twice as long as at the last one.
CalibratorConfig seldomFitted() {
  CalibratorConfig config = configFor(kMostLights);
  config.refit_growth = 1.0;
  return config;
}

/// As SeveralLights is shown them.
std::vector<Frame> framesOf(const SimulatedRecord& record) {
  Calibrator calibrator(seldomFitted(), FitsRun::kBeside);
  std::vector<Frame> frames;
  calibrator.observe([&](const AssociationOutcome& outcome) {
    frames.push_back(
        {record.bearings[frames.size()], outcome.observation.motion, outcome.observation.nearby});
  });
  Player(record).play(&calibrator);
  return frames;
}

/// Shows one, and waits for the fit that it makes due.
AssociationOutcome showInPeace(const Frame& frame, FitsBeside* fits) {
  const AssociationOutcome outcome = fits->process(frame);
  waitFor([&] {
    fits->takeOver();
    return !fits->report().under_way;
  });
  return outcome;
}

/// Goes on with bearings that mean nothing until the light is lost.
/// @returns false when no fit was under way at that moment
bool loseTheLight(std::uint64_t seed) {
  constexpr std::size_t kHidden = 300;
  std::vector<Frame> frames = framesOf(danceWith(1, 80.0));
  Draws draws(seed, Draws::Purpose::kOcclusions);
  for (std::size_t i = kHidden; i < frames.size(); ++i) {
    frames[i].image.candidates.at(0).azimuth_rad = draws.angle();
  }
  FitsBeside fits(configFor(1), FitsRun::kBeside);
  for (std::size_t i = 0; i < kHidden; ++i) showInPeace(frames[i], &fits);
  // as fast as they come: what takes the worker milliseconds is under way meanwhile
  for (std::size_t i = kHidden; i < frames.size(); ++i) {
    fits.takeOver();
    const FitsReport before = fits.report();
    if (!fits.process(frames[i]).lost_light) continue;
    const FitsReport after = fits.report();
    if (!before.under_way || after.taken > before.taken) return false;
    EXPECT_EQ(after.dropped, before.dropped + 1);
    waitFor([&] {
      fits.takeOver();
      return !fits.report().under_way;
    });
    EXPECT_EQ(fits.report().taken, after.taken);
    return true;
  }
  ADD_FAILURE() << "the light was not lost";
  return true;
}

// An input that comes at the moment when a fit ends takes it over and may begin the next one before
// the worker's thread has gone on. Who asks without a pause meets that moment often.
// Promise unharmed: inputs at the very moment when a fit ends
TEST(FitsBeside, AFitThatBeginsAsOneEndsIsNotLost) {
  constexpr int kDrives = 2;
  constexpr std::size_t kImages = 12;  // at once: the next fit is due when this one has ended
  CalibratorConfig config = configFor(1);
  config.refit_growth = 0.0;
  const std::vector<Frame> frames = framesOf(danceWith(1, 60.0));
  std::uint32_t begun_at_an_end = 0;
  for (int drive = 0; drive < kDrives; ++drive) {
    FitsBeside fits(config, FitsRun::kBeside);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      fits.process(frames[i]);
      if (i % kImages != 0) continue;
      const std::uint32_t taken = fits.report().taken;
      do fits.takeOver();
      while (fits.report().under_way);
      ASSERT_FALSE(fits.live().isWorkDue()) << "image " << i << ", drive " << drive;
      if (fits.report().taken > taken + 1) ++begun_at_an_end;
    }
    ASSERT_EQ(fits.report().dropped, 0U);
  }
  EXPECT_GT(begun_at_an_end, 0U);
}

TEST(FitsBeside, ANewStartDropsTheFitThatWasBegunBeforeIt) {
  std::uint64_t seed = 1;
  while (!loseTheLight(seed)) ++seed;
}

TEST(FitsBeside, ADisplacedMountIsCalibratedAnewWhereTheOwnerWantsIt) {
  SimulatedCase simulated = paperCase(1);
  simulated.duration_s = 150.0;
  SimulatedRecord record = simulate(simulated).record;
  simulated.robot.base_from_sensor.yaw_rad += radiansFromDegrees(20.0);
  const SimulatedRecord after = simulate(simulated).record;
  constexpr std::size_t kDisplaced = 600;
  std::copy(after.bearings.begin() + kDisplaced, after.bearings.end(),
            record.bearings.begin() + kDisplaced);
  CalibratorConfig config = configFor(1);
  config.restart_on_mount_change = true;
  Calibrator calibrator(config, FitsRun::kBeside);
  bool was_told = false;
  Player(record).play(&calibrator, [&] {
    was_told = was_told || calibrator.result().advice.find("has moved") != std::string::npos;
    return true;
  });
  EXPECT_TRUE(was_told);
  const CalibrationResult result = calibrator.result();
  EXPECT_EQ(result.state, CalibrationState::kConverged) << result.advice;
  constexpr double kWrong = 25.0;  // chi-square(3): one honest answer in 60 000
  EXPECT_LT(testing::mountChiSquare(*result.base_from_sensor, simulated.robot.base_from_sensor),
            kWrong);
}

// A fit may take long, and what it then says is of the past.
// Promise honest: a mount that is displaced under several lights, while a fit goes on
TEST(FitsBeside, AreNotWaitedForWhereTheBearingsCeaseToFit) {
  constexpr int kLights = 4;
  constexpr double kDuration_s = 60.0;
  constexpr std::size_t kDisplaced = 550;
  constexpr std::size_t kNoticed = 20;  // half of 100 bearings come with 13 images
  const std::vector<Frame> before = framesOf(danceWith(kLights, kDuration_s));
  const std::vector<Frame> after =
      framesOf(danceWith(kLights, kDuration_s, 3, radiansFromDegrees(8.0)));
  SeveralLights calibration(configFor(kLights), FitsRun::kBeside);
  const auto state = [&] {
    CalibrationResult result;
    calibration.describe(&result);
    return result.state;
  };
  for (std::size_t i = 0; i < kDisplaced; ++i) {
    calibration.process(before[i]);
    if (calibration.isWorkDue()) calibration.work();
  }
  EXPECT_EQ(state(), CalibrationState::kConverged);
  for (std::size_t i = kDisplaced; i < after.size(); ++i) {
    calibration.process(after[i]);
    if (i < kDisplaced + kNoticed) continue;
    ASSERT_EQ(state(), CalibrationState::kConverging) << i;
  }
}

// A fit refuses a variance below 0, which no input lets in; what follows the light does not mind
// one so small.
// Promise alive: an exception in a fit
TEST(FitsBeside, AnErrorOfAFitIsThrownWhereTheInputsCome) {
  std::vector<Frame> frames = framesOf(danceWith(1, 40.0));
  for (Frame& frame : frames) frame.image.candidates.at(0).azimuth_variance_rad2 = -1e-12;
  FitsBeside fits(configFor(1), FitsRun::kBeside);
  int errors = 0;
  for (const Frame& frame : frames) {
    showInPeace(frame, &fits);
    try {
      fits.rethrow();
    } catch (const std::invalid_argument&) {
      ++errors;
    }
  }
  EXPECT_GT(errors, 0);
  EXPECT_NO_THROW(fits.rethrow());  // each is told once
}

/// The longest that a fit of any kind goes on for once it is cancelled, of tries at many moments.
double longestToCancel(const std::function<void()>& work) {
  constexpr double kFirst_s = 0.002;
  constexpr double kLater = 1.25;
  double longest_s = 0.0;
  int tries = 0;
  bool is_cancelled = true;
  for (double wait_s = kFirst_s; is_cancelled; wait_s *= kLater) {
    std::atomic<Epoch> epoch{0};
    std::atomic<bool> is_done{false};
    double ended_s = 0.0;
    is_cancelled = false;
    std::thread worker([&] {
      try {
        const WorkOfEpoch own(epoch, 0);
        work();
      } catch (const Cancelled&) {
        is_cancelled = true;
      }
      ended_s = ownCpuSeconds();
      is_done = true;
      // its clock must be there to be read
      while (epoch == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
    clockid_t clock{};
    pthread_getcpuclockid(worker.native_handle(), &clock);
    while (!is_done && cpuSeconds(clock) < wait_s) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const double cancelled_s = cpuSeconds(clock);
    epoch = 1;
    worker.join();
    if (is_cancelled) longest_s = std::max(longest_s, ended_s - cancelled_s);
    tries += is_cancelled ? 1 : 0;
  }
  EXPECT_GT(tries, 0) << "too quick to be cancelled";
  return longest_s;
}

/// As it is when work is due for the last time.
SeveralLights withWorkDue(const std::vector<Frame>& frames, const CalibratorConfig& config) {
  SeveralLights lights(config, FitsRun::kBeside);
  SeveralLights due = lights;
  for (const Frame& frame : frames) {
    lights.process(frame);
    if (!lights.isWorkDue()) continue;
    due = lights;
    lights.work();
  }
  EXPECT_TRUE(due.isWorkDue());
  return due;
}

TEST(FitsBeside, EndWithinATenthOfASecondWhenTheyAreCancelled) {
  constexpr double kBar_s = 0.1;
  const std::vector<Frame> frames = framesOf(danceWith(kMostLights, 130.0));
  CalibratorConfig all = configFor(kMostLights);
  all.refit_growth = 0.1;  // seldom, so that all is due at the same time
  all.initializer.noise = {0.7, 0.7};
  const SeveralLights lights = withWorkDue(frames, all);
  const double lights_s = longestToCancel([&] { SeveralLights(lights).work(); });

  std::vector<Frame> wrong = frames;  // bearings that no mount explains
  std::vector<Observation> observations;
  for (Frame& frame : wrong) {
    frame.image.candidates.resize(1);
    Bearing& bearing = frame.image.candidates[0];
    bearing.azimuth_rad = wrapAngle(-2.0 * bearing.azimuth_rad);
    observations.push_back({frame.image.stamp, frame.motion, bearing.azimuth_rad,
                            bearing.azimuth_variance_rad2, frame.nearby});
  }
  const CalibratorConfig one = configFor(1);
  const SeveralLights vain = withWorkDue(wrong, one);
  const double start_s = longestToCancel([&] { SeveralLights(vain).work(); });
  const double diagnosis_s = longestToCancel(
      [&] { findFault(observations, one.drive.wheel_separation_m, one.initializer); });
  constexpr double kMilli = 1e3;
  std::printf("CPU time to the end: lights %.2f ms, start %.2f ms, diagnosis %.2f ms\n",
              kMilli * lights_s, kMilli * start_s, kMilli * diagnosis_s);
  EXPECT_LT(lights_s, kBar_s);
  EXPECT_LT(start_s, kBar_s);
  EXPECT_LT(diagnosis_s, kBar_s);
}

/// CPU time of the filter alone for an image.
double meanOfFilter_s(const std::vector<Frame>& frames) {
  SeveralLights lights(seldomFitted(), FitsRun::kBeside);
  double all_s = 0.0;
  for (const Frame& frame : frames) {
    const double begin_s = ownCpuSeconds();
    lights.process(frame);
    all_s += ownCpuSeconds() - begin_s;
    if (lights.isWorkDue()) lights.work();
  }
  return all_s / static_cast<double>(frames.size());
}

TEST(FitsBeside, CostTheInputsLittleMoreThanTheFilter) {
  constexpr double kMostTimes = 10.0;
  const SimulatedRecord record = danceWith(kMostLights, 150.0);
  Calibrator calibrator(configFor(kMostLights), FitsRun::kBeside);
  Player player(record);
  calibrator.observe([&](const AssociationOutcome&) { player.seeImage(); });
  player.play(&calibrator);
  const double filter_s = meanOfFilter_s(framesOf(record));
  const double times = player.meanOfImages_s() / filter_s;
  constexpr double kMicro = 1e6;
  constexpr double kPercent = 100.0;
  std::printf(
      "CPU time of an image: %.0f us in the mean, %.1f times the filter's %.0f us; of the longest "
      "input: %.0f us; a fit under way at %.0f %% of the images, %u taken over\n",
      kMicro * player.meanOfImages_s(), times, kMicro * filter_s, kMicro * player.longestInput_s(),
      kPercent * player.shareWithFit(), calibrator.fits().taken);
  EXPECT_LT(times, kMostTimes);
}

TEST(FitsBeside, AreNotWaitedForAtTheEnd) {
  const SimulatedRecord record = danceWith(1, 40.0);
  for (std::uint32_t fits = 1; fits < 5; ++fits) {
    Calibrator calibrator(configFor(1), FitsRun::kBeside);
    Player(record).play(&calibrator, [&] {
      return calibrator.fits().taken < fits || !calibrator.fits().under_way;
    });
    EXPECT_TRUE(calibrator.fits().under_way);
  }
}

}  // namespace
}  // namespace bearing_calibration::core
