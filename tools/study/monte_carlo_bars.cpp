#include "tools/study/monte_carlo_bars.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

/// A bar that just holds is missed by chance in so many samples.
constexpr double kFalseAlarm = 1e-3;

double mostOf(int trials, double probability) {
  if (trials == 0) return 0.0;
  return boost::math::quantile(
      boost::math::complement(boost::math::binomial(trials, probability), kFalseAlarm));
}

Bar atMost(const std::string& sentence, double value, double limit) {
  return {sentence, value, limit, value <= limit};
}

/// All tests together may be wrong in one sound run of a thousand.
void judgeAlarms(const std::vector<Trial>& trials, std::vector<Bar>& bars) {
  constexpr double kAlarms = 1e-3;
  const auto sound = std::count_if(trials.begin(), trials.end(),
                                   [](const Trial& trial) { return trial.is_sound; });
  const auto alarms = std::count_if(trials.begin(), trials.end(), [](const Trial& trial) {
    return trial.is_sound && !trial.alarm.empty();
  });
  if (sound == 0) return;
  bars.push_back(atMost("sound runs called INCONSISTENT at any time", static_cast<double>(alarms),
                        mostOf(static_cast<int>(sound), kAlarms)));
}

void judgeRow(const TableRow& row, std::vector<Bar>& bars) {
  constexpr double kMissedShare = 0.005;  // of the possible ones
  constexpr double kBeyondShare = 0.018;
  constexpr double kLeastNees = 0.9;
  constexpr double kMostNees = 1.1;
  constexpr double kMostEarlyNees = 1.2;
  constexpr double kEarly_s = 20.0;
  constexpr int kMountDegrees = 3;
  const std::string at = " at " + std::to_string(static_cast<int>(row.time_s)) + " s";
  bars.push_back(atMost("possible but not declared" + at, row.possible - row.possible_claimed,
                        mostOf(row.possible, kMissedShare)));
  bars.push_back(
      atMost("beyond the 99 % ellipsoid" + at, row.beyond, mostOf(row.claimed, kBeyondShare)));
  if (row.claimed == 0) return;
  const double degrees = kMountDegrees * row.claimed;
  const double most = row.time_s <= kEarly_s ? kMostEarlyNees : kMostNees;
  bars.push_back(atMost("NEES per degree" + at, row.mount_nees,
                        most * chiSquareQuantile(1.0 - kFalseAlarm, degrees) / degrees));
  bars.push_back(atMost("least NEES per degree" + at,
                        kLeastNees * chiSquareQuantile(kFalseAlarm, degrees) / degrees,
                        row.mount_nees));
}

/// Nothing is forgotten: an estimate is nearer to the fit of the whole record than that is to the
/// truth.
void judgeWhole(const TableRow& row, std::vector<Bar>& bars) {
  constexpr double kMostOffWhole = 0.45;  // of the bound
  if (row.whole == 0) return;
  bars.push_back(atMost("off the whole record's fit, per bound, at " +
                            std::to_string(static_cast<int>(row.time_s)) + " s",
                        row.off_whole_per_bound.maxCoeff(), kMostOffWhole));
}

}  // namespace

std::vector<Bar> judgeBars(const std::vector<Trial>& trials, const std::vector<TableRow>& rows,
                           ClaimKind kind) {
  std::vector<Bar> bars;
  const auto claims = std::count_if(trials.begin(), trials.end(), [](const Trial& trial) {
    return trial.first_claim_s.has_value();
  });
  const auto wrong = std::count_if(trials.begin(), trials.end(), [](const Trial& trial) {
    return trial.worst_claim > kWrongChiSquare;
  });
  if (kind == ClaimKind::kForbidden) {
    bars.push_back(atMost("runs declared converged", static_cast<double>(claims), 0.0));
    return bars;
  }
  constexpr double kWrongEstimates = 1e-3;
  const double most_wrong =
      kind == ClaimKind::kVerdict ? 0.0 : mostOf(static_cast<int>(trials.size()), kWrongEstimates);
  bars.push_back(atMost("runs wrongly declared converged at any time", static_cast<double>(wrong),
                        most_wrong));
  judgeAlarms(trials, bars);
  if (!rows.empty()) judgeRow(rows.back(), bars);
  for (const TableRow& row : rows) judgeWhole(row, bars);
  return bars;
}

std::string format(const std::vector<Bar>& bars) {
  std::string text;
  for (const Bar& bar : bars) {
    text += formatted("%s: %s %.3f (at most %.3f)\n", bar.reached ? "reached" : "MISSED",
                      bar.sentence.c_str(), bar.value, bar.limit);
  }
  return text;
}

bool allReached(const std::vector<Bar>& bars) {
  return std::all_of(bars.begin(), bars.end(), [](const Bar& bar) { return bar.reached; });
}

}  // namespace bearing_calibration::core
