// Runs an estimator on many simulated robots and prints how often and how far it is right:
// monte_carlo --help

#include <boost/program_options.hpp>
#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

#include "bearing_calibration/common/formatted.h"
#include "tools/common/command_line.h"
#include "tools/common/parallel.h"
#include "tools/study/lights_case.h"
#include "tools/study/monte_carlo_bars.h"
#include "tools/study/monte_carlo_table.h"
#include "tools/study/monte_carlo_trials.h"
#include "tools/study/unmodelled.h"

namespace bearing_calibration::core {
namespace {

namespace options = boost::program_options;

constexpr int kBarMissed = 1;
// What imperfect.md says to try.
constexpr double kUsualHarmonic_rad = 0.03;
constexpr double kUsualTilt_rad = 0.035;

struct Arguments {
  std::string what;
  std::string world;
  std::string trajectory;
  int runs = 0;
  int threads = 0;
  std::uint64_t seed = 0;
  double duration_s = 0.0;
  std::vector<double> times_s;
  double outliers = 0.0;
  double correlation = 0.0;
  int slips = 0;
  double occlusion = 0.0;
  int lights = 1;
  double moving_light_mps = 0.0;
  double hide_in_turn_s = 0.0;
  bool unidentified = false;
  ImperfectRobot imperfect;
  double light_height_m = 0.0;
  double elevation_stddev_deg = 0.0;
  double tilt_deg = 0.0;
  double harmonic_deg = 0.0;
  ErrorPriors looked_for;
  double scales_prior = 0.0;
  NoiseLevels stated_noise;
  bool random_noise = false;
  std::string unmodelled;
  bool fit_whole_record = false;
  NoisePriors noise_looked_for;
};

options::options_description describeOptions(Arguments* arguments) {
  options::options_description description(
      "monte_carlo --what initialiser|batch|calibrator --world random|paper|corner|short "
      "[options]\n\n"
      "Exit status 1 when a bar of doc/evidence/accuracy.md is missed (see --check)");
  auto add = description.add_options();
  add("help,h", "print this");
  add("what", options::value(&arguments->what)->default_value("initialiser"),
      "initialiser, batch or calibrator");
  add("world", options::value(&arguments->world)->default_value("random"),
      "random: any mount, light and heading; paper: section V of the paper; corner: its dance "
      "about a "
      "square with the light inside near a corner; short: 6 m with a sensor of 2 deg, as "
      "published");
  add("trajectory", options::value(&arguments->trajectory)->default_value("mixed"),
      "mixed (dance, turns, sinusoid, random in turn), degenerate (standing, line, back_and_forth, "
      "circle, spin, a line through the light and a circle about it in turn) or one by its name");
  add("runs", options::value(&arguments->runs)->default_value(200), "number of runs");
  add("threads", options::value(&arguments->threads)->default_value(2), "at work");
  add("seed", options::value(&arguments->seed)->default_value(1), "of the first run");
  add("duration", options::value(&arguments->duration_s)->default_value(100.0), "of a run [s]");
  add("times", options::value(&arguments->times_s)->multitoken(),
      "moments to report [s]; the run's end is always reported");
  add("outliers", options::value(&arguments->outliers)->default_value(0.0),
      "share of uniform false bearings");
  add("correlation", options::value(&arguments->correlation)->default_value(0.0),
      "of a bearing's noise with the next one's");
  add("slips", options::value(&arguments->slips)->default_value(0), "of a wheel in each run");
  add("occlusion", options::value(&arguments->occlusion)->default_value(0.0),
      "share of the run without light");
  add("lights", options::value(&arguments->lights)->default_value(1), "that share the mount");
  add("unidentified", options::bool_switch(&arguments->unidentified),
      "nobody says which of several lights is which");
  add("moving-light", options::value(&arguments->moving_light_mps)->default_value(0.0),
      "the last of several lights moves as fast [m/s]");
  add("hide-in-turn", options::value(&arguments->hide_in_turn_s)->default_value(0.0),
      "one of several lights is hidden for so long, then the next one [s]");
  ImperfectRobot& robot = arguments->imperfect;
  add("errors", "estimate time offset, wheel scales and separation");
  add("offset", options::value(&robot.time_offset_s)->default_value(0.0),
      "stamps are late by this [s]");
  add("ratio", options::value(&robot.ratio)->default_value(0.0), "of the wheels' scales, less 1");
  add("scale", options::value(&robot.scale)->default_value(0.0), "of both wheels, less 1");
  add("random-offset", options::value(&robot.max_random_offset_s)->default_value(0.0),
      "added, uniform from 0 to this [s]");
  add("random-ratio", options::value(&robot.random_ratio_stddev)->default_value(0.0),
      "added, standard deviation");
  add("random-scale", options::value(&robot.random_scale_stddev)->default_value(0.0),
      "of both wheels, added, standard deviation");
  add("random-separation", options::value(&robot.random_separation_stddev)->default_value(0.0),
      "of the wheels, standard deviation");
  add("scales-prior", options::value(&arguments->scales_prior)->default_value(0.03),
      "what --errors takes the wheels' scales to be known to");
  add("known-separation", "estimate time offset and wheel scales alone");
  add("stated-bearing-noise",
      options::value(&arguments->stated_noise.bearing.value)->default_value(1.0),
      "the stated standard deviation of the bearings over the true one");
  add("stated-wheel-noise",
      options::value(&arguments->stated_noise.wheel.value)->default_value(1.0),
      "the stated variance of the wheels over the true one");
  add("estimate-noise", "estimate the noise of bearings and wheels");
  add("random-noise", options::bool_switch(&arguments->random_noise),
      "bearings 1/3 to 4 times, the wheels' variance 1/10 to 100 times as noisy as stated, "
      "bearings correlated by up to 0.8");
  add("unmodelled", options::value(&arguments->unmodelled)->default_value("none"),
      ("what no model of the estimators knows: " + joined(unmodelledNames(), ", ")).c_str());
  add("tilt", options::value(&arguments->tilt_deg)->default_value(0.0),
      "of the sensor, in any direction [deg]");
  add("harmonic", options::value(&arguments->harmonic_deg)->default_value(0.0),
      "first harmonic of the mirror, of any phase [deg]");
  add("elevations", options::value(&arguments->elevation_stddev_deg)->default_value(0.0),
      "standard deviation of the light's elevation [deg]; 0: it is not measured");
  add("light-height", options::value(&arguments->light_height_m)->default_value(0.0),
      "of the light over the sensor, the last of several as far below it [m]");
  add("estimate-harmonic", "estimate the mirror's first harmonic");
  add("estimate-tilt", "estimate the sensor's tilt and the lights' heights");
  add("whole-record", options::bool_switch(&arguments->fit_whole_record),
      "compare the calibrator's estimates with fits of the whole record, which it does not keep");
  add("check", "judge the bars");
  return description;
}

using Kind = TrajectoryConfig::Kind;

constexpr const char* kDegenerate = "degenerate";

Kind kindOfSeed(const std::string& trajectory, std::uint64_t seed) {
  static const std::vector<Kind> kMixed = {Kind::kDance, Kind::kTurns, Kind::kSinusoid,
                                           Kind::kRandom};
  if (trajectory == "mixed") return kMixed[(seed - 1) % kMixed.size()];
  const std::vector<std::string>& names = trajectoryNames();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == trajectory) return static_cast<Kind>(i);
  }
  throw std::invalid_argument("no trajectory is called " + trajectory);
}

/// World and trajectory by the seed alone: runs are repeatable.
SimulatedCase idealCase(const Arguments& arguments, std::uint64_t seed) {
  if (arguments.trajectory == kDegenerate) return degenerateCase(seed);
  const Kind kind = kindOfSeed(arguments.trajectory, seed);
  if (arguments.world == "random") return randomCase(seed, kind, RandomCaseRange());
  if (arguments.world == "short") return shortCase(seed);
  if (arguments.world != "paper" && arguments.world != "corner") {
    throw std::invalid_argument("--world must be random, paper, corner or short, but is " +
                                arguments.world);
  }
  SimulatedCase simulated = arguments.world == "corner" ? cornerCase(seed) : paperCase(seed);
  if (arguments.trajectory != "mixed") simulated.trajectory.kind = kind;
  return simulated;
}

SimulatedCase makeCase(const Arguments& arguments, std::uint64_t run) {
  const std::uint64_t seed = arguments.seed + run;
  SimulatedCase simulated = idealCase(arguments, seed);
  simulated.duration_s = arguments.duration_s;
  simulated.robot.sensor.outlier_probability = arguments.outliers;
  simulated.robot.sensor.correlation = arguments.correlation;
  simulated.robot.sensor.elevation_stddev_rad = radiansFromDegrees(arguments.elevation_stddev_deg);
  if (arguments.lights > 1) {
    addLights(simulated, arguments.lights, seed);
    simulated.lights.back().velocity_mps.x() = arguments.moving_light_mps;
    simulated.robot.sensor.identifies_lights = true;
    simulated.are_lights_told = !arguments.unidentified;
    simulated.hide_in_turn_s = arguments.hide_in_turn_s;
  }
  spreadHeights(simulated, arguments.light_height_m);
  addSlips(simulated, arguments.slips, seed);
  addOcclusions(simulated, arguments.occlusion, seed);
  makeImperfect(simulated, arguments.imperfect, seed);
  simulated.looked_for = arguments.looked_for;
  simulated.stated_noise.bearing.value *= arguments.stated_noise.bearing.value;
  simulated.stated_noise.wheel.value *= arguments.stated_noise.wheel.value;
  if (arguments.random_noise) drawNoise(simulated, seed);
  makeUnmodelled(unmodelledFrom(arguments.unmodelled), simulated);
  simulated.fit_whole_record = arguments.fit_whole_record;
  simulated.noise_looked_for = arguments.noise_looked_for;
  return simulated;
}

TrialFunction trialOf(const std::string& what) {
  if (what == "initialiser") return tryInitializer;
  if (what == "batch") return tryBatch;
  if (what == "calibrator") return tryCalibrator;
  throw std::invalid_argument("--what must be initialiser, batch or calibrator, but is " + what);
}

/// All trials, in the order of their seeds whatever the number of threads.
std::vector<Trial> runAll(const Arguments& arguments) {
  const TrialFunction attempt = trialOf(arguments.what);
  makeCase(arguments, 0);  // throws on a name that is none
  std::vector<Trial> trials(static_cast<std::size_t>(arguments.runs));
  forEachInParallel(trials.size(), arguments.threads, [&](std::size_t i) {
    trials[i] = attempt(makeCase(arguments, i), arguments.times_s);
  });
  return trials;
}

/// The runs that are worth a look, by their seeds.
void printRemarkable(const std::vector<Trial>& trials, std::uint64_t first_seed) {
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const Trial& trial = trials[i];
    const Snapshot& end = trial.snapshots.back();
    const auto seed = static_cast<unsigned long long>(first_seed + i);
    if (trial.worst_claim > kWrongChiSquare) {
      std::printf("seed %llu: declared and wrong, chi-square %.1f\n", seed, trial.worst_claim);
    }
    if (end.failed() && !end.claims) {
      std::printf("seed %llu: failed, chi-square %.1f, but only %s\n", seed, end.mountChiSquare(),
                  end.words.c_str());
    }
    if (end.claims && end.stateChiSquare() > kWrongStateChiSquare) {
      std::printf(
          "seed %llu: declared, but the light is elsewhere, chi-square %.1f, the mount's %.1f\n",
          seed, end.stateChiSquare(), end.mountChiSquare());
    }
    if (end.possible && !end.claims) {
      std::printf("seed %llu: possible, but %s at the end\n", seed, end.words.c_str());
    }
    if (!trial.alarm.empty()) {
      std::printf("seed %llu: INCONSISTENT after %s\n", seed, trial.alarm.c_str());
    }
  }
}

int run(int argc, char** argv) {
  Arguments arguments;
  const options::options_description description = describeOptions(&arguments);
  const auto values = parseArguments(argc, argv, description);
  if (!values) return EXIT_SUCCESS;
  requireGreaterThan0("runs", arguments.runs);
  requireGreaterThan0("threads", arguments.threads);
  requireGreaterThan0("lights", arguments.lights);
  requireGreaterThan0("duration", arguments.duration_s);
  if (arguments.times_s.empty() || arguments.times_s.back() < arguments.duration_s) {
    arguments.times_s.push_back(arguments.duration_s);
  }
  if (values->count("errors") > 0) {
    arguments.looked_for = usualErrors();
    arguments.looked_for.setBlock(WheelScales::kName, arguments.scales_prior);
  }
  if (values->count("estimate-noise") > 0) arguments.noise_looked_for = usualNoise();
  if (values->count("known-separation") > 0) {
    arguments.looked_for.setBlock(WheelSeparation::kName, 0.0);
  }
  if (values->count("estimate-harmonic") > 0) {
    arguments.looked_for.setBlock(MirrorHarmonic::kName, kUsualHarmonic_rad);
  }
  if (values->count("estimate-tilt") > 0) {
    arguments.looked_for.setBlock(SensorTilt::kName, kUsualTilt_rad);
  }
  arguments.imperfect.tilt_rad = radiansFromDegrees(arguments.tilt_deg);
  arguments.imperfect.harmonic_rad = radiansFromDegrees(arguments.harmonic_deg);
  const std::vector<Trial> trials = runAll(arguments);
  const std::vector<TableRow> rows = summarise(trials);
  std::cout << format(rows) << formatWhole(rows) << formatClaims(trials) << formatErrors(trials);
  if (!(*values)["lights"].defaulted()) std::cout << formatBounds(trials);
  std::cout << formatRobotErrors(trials);
  printRemarkable(trials, arguments.seed);
  if (values->count("check") == 0) return 0;
  const ClaimKind kind = arguments.trajectory == kDegenerate ? ClaimKind::kForbidden
                         : arguments.what == "calibrator"    ? ClaimKind::kVerdict
                                                             : ClaimKind::kEstimate;
  const std::vector<Bar> bars = judgeBars(trials, rows, kind);
  std::cout << format(bars);
  return allReached(bars) ? 0 : kBarMissed;
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  return bearing_calibration::core::runProgram(
      "monte_carlo", [&] { return bearing_calibration::core::run(argc, argv); },
      bearing_calibration::core::kUsageError);
}
