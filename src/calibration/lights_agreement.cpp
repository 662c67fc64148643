#include "bearing_calibration/calibration/lights_agreement.h"

#include <algorithm>

#include "bearing_calibration/calibration/mount_agreement.h"
#include "bearing_calibration/common/chi_square.h"

namespace bearing_calibration {
namespace {

constexpr double kMountDegrees = 3.0;
/// Of calling one of several sound lights a contradicting one.
constexpr double kFalseAlarm = 1e-4;
/// Of waiting with a verdict: two lights so far apart pull their joint answer about as far from the
/// truth as a wrong one is, if one of the two is wrong.
constexpr double kFalseDoubt = 1e-3;

/// Chi-square of two mounts that all pairs of `lights` stay below, but for one in 1/`probability`.
double limitFor(std::size_t lights, double probability) {
  const double pairs = std::max(1.0, 0.5 * static_cast<double>(lights * (lights - 1)));
  return chiSquareQuantile(1.0 - probability / pairs, kMountDegrees);
}

/// What speaks against one light.
struct Objection {
  int lights = 0;  ///< that it contradicts
  double chi_square = 0.0;

  bool operator<(const Objection& other) const {
    return lights != other.lights ? lights < other.lights : chi_square < other.chi_square;
  }
};

Objection objectionTo(std::size_t light, const std::vector<std::size_t>& others,
                      const std::vector<MountEstimate>& mounts, double limit) {
  Objection objection;
  for (std::size_t other : others) {
    if (other == light) continue;
    const double chi_square = disagreement(mounts[light], mounts[other]);
    objection.lights += chi_square > limit ? 1 : 0;
    objection.chi_square += chi_square;
  }
  return objection;
}

}  // namespace

LightsAgreement compareLights(const std::vector<MountEstimate>& mounts) {
  LightsAgreement agreement;
  const double limit = limitFor(mounts.size(), kFalseAlarm);
  std::vector<std::size_t>& agreeing = agreement.agreeing;
  for (std::size_t i = 0; i < mounts.size(); ++i) agreeing.push_back(i);
  const auto objection = [&](std::size_t light) {
    return objectionTo(light, agreeing, mounts, limit);
  };
  while (agreeing.size() > 1) {
    const auto worst =
        std::max_element(agreeing.begin(), agreeing.end(),
                         [&](std::size_t a, std::size_t b) { return objection(a) < objection(b); });
    if (objection(*worst).lights == 0) break;
    agreement.contradicting.push_back(*worst);
    agreeing.erase(worst);
  }
  agreement.has_majority = agreeing.size() > agreement.contradicting.size();
  const double doubt = limitFor(mounts.size(), kFalseDoubt);
  agreement.is_clear = std::all_of(agreeing.begin(), agreeing.end(), [&](std::size_t light) {
    return objectionTo(light, agreeing, mounts, doubt).lights == 0;
  });
  return agreement;
}

}  // namespace bearing_calibration
