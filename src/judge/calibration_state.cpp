#include "bearing_calibration/judge/calibration_state.h"

#include <array>

namespace bearing_calibration::core {
namespace {

struct StateWords {
  const char* name;
  const char* advice;
};

constexpr std::array<StateWords, 8> kStateWords{{
    {"WAITING_FOR_TICKS",
     "no wheel readings yet that can be used: check their topic, and rejections"},
    {"WAITING_FOR_LIGHT", "no bearing yet: bring the light into view"},
    {"INITIALISING", "drive about 1 m straight, turn on the spot, repeat"},
    {"CONVERGING", "keep driving straight lines and turns near the light"},
    {"CONVERGED", "the calibration is done: save it"},
    {"DEGENERATE_MOTION",
     "the mount is not observable with this motion: drive straight lines and turns"},
    {"INCONSISTENT", "the bearings do not fit the wheels' motion"},
    {"PAUSED", "paused: call ~pause with false to go on"},
}};
static_assert(kStateWords.size() == static_cast<std::size_t>(CalibrationState::kPaused) + 1);

const StateWords& wordsFor(CalibrationState state) {
  return kStateWords.at(static_cast<std::size_t>(state));
}

}  // namespace

const char* nameOf(CalibrationState state) { return wordsFor(state).name; }

const char* adviceFor(CalibrationState state) { return wordsFor(state).advice; }

}  // namespace bearing_calibration::core
