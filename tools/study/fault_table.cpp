// Robots with one fault each, whose noise the calibration does not know: how often it names the
// fault, and what it does where it has a term for it: fault_table --help

#include <algorithm>
#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/judge/fault.h"
#include "tools/common/command_line.h"
#include "tools/common/parallel.h"
#include "tools/study/monte_carlo_trials.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

namespace options = boost::program_options;

/// One way in which a robot is not what its owner believes.
struct FaultCase {
  std::string name;
  Fault fault = Fault::kNone;
  void (*make)(SimulatedCase* simulated) = nullptr;  ///< on a sound robot
  bool keeps_mount = true;                           ///< the mount is the same in all of the run
};

void leaveSound(SimulatedCase* /*simulated*/) {}

void swapWheels(SimulatedCase* simulated) {
  simulated->change_record = [](SimulatedRecord* record) {
    for (WheelCounts& ticks : record->ticks) std::swap(ticks.left_ticks, ticks.right_ticks);
  };
}

void reverseLeft(SimulatedCase* simulated) {
  simulated->change_record = [](SimulatedRecord* record) {
    for (WheelCounts& ticks : record->ticks) ticks.left_ticks = -ticks.left_ticks;
  };
}

void reverseRight(SimulatedCase* simulated) {
  simulated->change_record = [](SimulatedRecord* record) {
    for (WheelCounts& ticks : record->ticks) ticks.right_ticks = -ticks.right_ticks;
  };
}

void turnBearingsClockwise(SimulatedCase* simulated) {
  simulated->change_record = [](SimulatedRecord* record) {
    for (BearingSet& image : record->bearings) {
      for (Bearing& bearing : image.candidates) bearing.azimuth_rad = -bearing.azimuth_rad;
    }
  };
}

void delayCamera(SimulatedCase* simulated) {
  constexpr double kLate_s = 0.1;
  simulated->robot.stamp_latency_s = kLate_s;
}

void enlargeRightWheel(SimulatedCase* simulated) {
  constexpr double kFactor = 1.1;  // true over believed
  simulated->robot.encoders.right_radius_factor = kFactor;
}

void enlargeSeparation(SimulatedCase* simulated) {
  constexpr double kFactor = 1.1;  // true over believed
  simulated->robot.separation_factor = kFactor;
}

/// As where other edges of a tick count than the owner believes, or a diameter is given for a
/// radius.
template <int kTimes>
void countMoreTicks(SimulatedCase* simulated) {
  simulated->change_record = [](SimulatedRecord* record) {
    for (WheelCounts& ticks : record->ticks) {
      ticks.left_ticks *= kTimes;
      ticks.right_ticks *= kTimes;
    }
  };
}

/// From a moment on, what another robot of the same drive would have seen.
void becomeAfter(double seconds, const SimulatedCase& other, SimulatedCase* simulated) {
  simulated->change_record = [seconds, other](SimulatedRecord* record) {
    const SimulatedRecord later = simulate(other).record;
    const Stamp since = record->ticks.front().stamp + durationFromSeconds(seconds);
    for (std::size_t i = 0; i < record->bearings.size(); ++i) {
      if (record->bearings[i].stamp >= since) record->bearings[i] = later.bearings[i];
    }
  };
}

void moveLight(SimulatedCase* simulated) {
  constexpr double kAfter_s = 30.0;
  SimulatedCase moved = *simulated;
  moved.lights[0].position_m += Eigen::Vector2d(0.6, -0.8);
  becomeAfter(kAfter_s, moved, simulated);
}

void displaceMount(SimulatedCase* simulated) {
  constexpr double kAfter_s = 100.0;  // CONVERGED
  SimulatedCase displaced = *simulated;
  displaced.robot.base_from_sensor.position_m.x() += 0.02;
  displaced.robot.base_from_sensor.yaw_rad += radiansFromDegrees(5.0);
  becomeAfter(kAfter_s, displaced, simulated);
}

/// A sound robot, and one with each fault of faults.md.
const std::vector<FaultCase>& faultCases() {
  static const std::vector<FaultCase> kCases = {
      {"none", Fault::kNone, leaveSound},
      {"left and right swapped", Fault::kMirrored, swapWheels},
      {"azimuth clockwise", Fault::kMirrored, turnBearingsClockwise},
      {"left reversed", Fault::kLeftReversed, reverseLeft},
      {"right reversed", Fault::kRightReversed, reverseRight},
      {"camera 0.1 s late", Fault::kLate, delayCamera},
      {"right wheel 10 % larger", Fault::kRightRadius, enlargeRightWheel},
      {"separation 10 % larger", Fault::kSeparation, enlargeSeparation},
      {"ticks counted twice", Fault::kSeparation, countMoreTicks<2>},
      {"ticks counted four times", Fault::kSeparation, countMoreTicks<4>},
      {"light moved by 1 m after 30 s", Fault::kLightMoved, moveLight},
      {"mount displaced by 2 cm and 5 deg after 100 s", Fault::kMountMoved, displaceMount, false},
  };
  return kCases;
}

/// How the runs of one fault went.
struct FaultCount {
  int named = 0;         ///< by its own name
  int misnamed = 0;      ///< by another fault's, at any second
  int converged = 0;     ///< at the end, of those that are not named
  int wrong = 0;         ///< CONVERGED at a wrong mount, at any second
  int without_name = 0;  ///< INCONSISTENT at some time, and never with a name
};

/// Of those that the owner can put right; the others say only that nothing fits.
bool isName(Fault cause) { return cause != Fault::kNone && cause <= Fault::kMountMoved; }

FaultCount countOf(const FaultCase& fault, const std::vector<Trial>& trials) {
  FaultCount count;
  for (const Trial& trial : trials) {
    const bool is_named = trial.causes.count(fault.fault) > 0 && isName(fault.fault);
    const bool is_misnamed =
        std::any_of(trial.causes.begin(), trial.causes.end(),
                    [&](Fault cause) { return isName(cause) && cause != fault.fault; });
    count.named += is_named ? 1 : 0;
    count.misnamed += is_misnamed ? 1 : 0;
    count.converged += !is_named && trial.snapshots.back().claims ? 1 : 0;
    count.wrong += fault.keeps_mount && trial.worst_claim > kWrongChiSquare ? 1 : 0;
    count.without_name += !trial.causes.empty() && !is_named && !is_misnamed ? 1 : 0;
  }
  return count;
}

/// The runs that ask for another look, by their seeds: those whose fault is not named, unless they
/// were never INCONSISTENT and end CONVERGED.
std::string remarksOn(const FaultCase& fault, const std::vector<Trial>& trials,
                      std::uint64_t first_seed) {
  std::string remarks;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const Trial& trial = trials[i];
    const Snapshot& end = trial.snapshots.back();
    if (trial.causes.count(fault.fault) > 0 || (trial.causes.empty() && end.claims)) continue;
    remarks += fault.name + ", seed " + std::to_string(first_seed + i) + ": " + end.words;
    for (Fault cause : trial.causes) remarks += std::string(", ") + nameOf(cause);
    remarks += "\n";
  }
  return remarks;
}

SimulatedCase caseOf(const FaultCase& fault, std::uint64_t seed, double duration_s) {
  SimulatedCase simulated = paperCase(seed);
  simulated.duration_s = duration_s;
  simulated.looked_for = usualErrors();
  simulated.noise_looked_for = usualNoise();
  fault.make(&simulated);
  return simulated;
}

/// Until the fault is named: then the owner stops, and the rest of a run costs most.
Trial tryUntilNamed(const FaultCase& fault, std::uint64_t seed, double duration_s) {
  for (double so_far_s = duration_s / 4.0; so_far_s < duration_s; so_far_s *= 2.0) {
    Trial trial = tryCalibrator(caseOf(fault, seed, so_far_s), {so_far_s});
    if (trial.causes.count(fault.fault) > 0) return trial;
    if (trial.causes.empty()) break;  // nothing is suspected: on to the end
  }
  return tryCalibrator(caseOf(fault, seed, duration_s), {duration_s});
}

std::vector<FaultCase> faultsWith(const std::string& part_of_name) {
  std::vector<FaultCase> faults;
  std::copy_if(
      faultCases().begin(), faultCases().end(), std::back_inserter(faults),
      [&](const FaultCase& fault) { return fault.name.find(part_of_name) != std::string::npos; });
  return faults;
}

int run(int argc, char** argv) {
  int runs = 0;
  int threads = 0;
  std::uint64_t seed = 0;
  double duration_s = 0.0;
  std::string only;
  options::options_description description("fault_table [options]");
  auto add = description.add_options();
  add("help,h", "print this");
  add("runs", options::value(&runs)->default_value(100), "of each fault");
  add("threads", options::value(&threads)->default_value(2), "at work");
  add("seed", options::value(&seed)->default_value(1), "of the first run");
  add("duration", options::value(&duration_s)->default_value(150.0), "of a run [s]");
  add("only", options::value(&only)->default_value(""), "faults whose names contain this");
  if (!parseArguments(argc, argv, description)) return EXIT_SUCCESS;
  requireGreaterThan0("runs", runs);
  requireGreaterThan0("threads", threads);
  requireGreaterThan0("duration", duration_s);
  const std::vector<FaultCase> faults = faultsWith(only);
  if (faults.empty()) throw std::invalid_argument("no fault's name contains " + only);
  std::printf(
      "| fault | runs | named | another one named | INCONSISTENT without a name | CONVERGED at the "
      "end, not named | wrong at any second |\n|---|---|---|---|---|---|---|\n");
  std::string remarks;
  for (const FaultCase& fault : faults) {
    std::vector<Trial> trials(static_cast<std::size_t>(runs));
    forEachInParallel(trials.size(), threads, [&](std::size_t i) {
      trials[i] = tryUntilNamed(fault, seed + i, duration_s);
    });
    const FaultCount count = countOf(fault, trials);
    std::printf("| %s | %d | %s | %d | %d | %d | %s |\n", fault.name.c_str(), runs,
                isName(fault.fault) ? std::to_string(count.named).c_str() : "", count.misnamed,
                count.without_name, count.converged,
                fault.keeps_mount ? std::to_string(count.wrong).c_str() : "");
    std::fflush(stdout);
    remarks += remarksOn(fault, trials, seed);
  }
  std::printf("%s", remarks.c_str());
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  return bearing_calibration::core::runProgram(
      "fault_table", [&] { return bearing_calibration::core::run(argc, argv); },
      bearing_calibration::core::kUsageError);
}
