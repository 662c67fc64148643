#include "bearing_calibration/record/scatter.h"

#include <algorithm>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/filter/state.h"

namespace bearing_calibration::core {
namespace {

constexpr double kProbability = 0.99;
/// The mean gain that one honest drive of a hundred exceeds. Of a whole record its 99 % quantile,
/// that of the sum over j of chi-squares of 3 degrees over j (j + 1), is 7.27, as of a chi-square
/// of 9 degrees with a mean of 3. Each quarter of a record that was given away adds about one
/// degree, as bridges that are cut so have it: 6.1 after 7 of them, 4.7 after 30.
double largestMeanByChance(int parts_given_away) {
  const double degrees = 9.0 + parts_given_away;
  return kMountSize * chiSquareQuantile(kProbability, degrees) / degrees;
}

/// The largest gain that one honest drive of a hundred exceeds, by DeLong's formula (1981) for the
/// supremum of a normalised bridge in 3 dimensions: 20.2 where the first and last 2 % of the
/// information tell no jump, 20.9 where half a per cent, 21.6 where a thousandth.
constexpr double kLargestGainByChance = 21.0;

}  // namespace

Scatter& Scatter::operator+=(const Scatter& other) {
  gain_sum += other.gain_sum;
  largest_gain = std::max(largest_gain, other.largest_gain);
  observations += other.observations;
  parts_given_away += other.parts_given_away;
  return *this;
}

void Scatter::giveAway(const Scatter& part) {
  *this += part;
  ++parts_given_away;
}

double Scatter::meanGain() const {
  return observations == 0 ? 0.0 : gain_sum / static_cast<double>(observations);
}

double Scatter::widening() const {
  const bool by_mean = meanGain() > largestMeanByChance(parts_given_away);
  return std::max(by_mean ? meanGain() / kMountSize : 1.0, largest_gain / kLargestGainByChance);
}

}  // namespace bearing_calibration::core
