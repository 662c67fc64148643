#include <algorithm>
#include <iomanip>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "tools/paper/paper_figures.h"

namespace bearing_calibration::core {
namespace {

constexpr int kDigits = 6;

/// (phi, rho, psi) in the units of the files.
Eigen::Vector3d shown(const Eigen::Vector3d& mount) {
  return {degreesFromRadians(mount(0)), kMillimetresPerMetre * mount(1),
          degreesFromRadians(mount(2))};
}

void writeNames(std::ostream& out, const std::string& what) {
  out << ",phi_" << what << "_deg,rho_" << what << "_mm,psi_" << what << "_deg";
}

void writeValues(std::ostream& out, const Eigen::Vector3d& mount) {
  for (double value : shown(mount)) out << ',' << value;
}

Eigen::Vector3d medianOf(std::vector<Eigen::Vector3d> sizes) {
  Eigen::Vector3d median;
  const std::size_t middle = sizes.size() / 2;
  for (int k = 0; k < 3; ++k) {
    std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(middle),
                     sizes.end(), [k](const auto& a, const auto& b) { return a(k) < b(k); });
    median(k) = sizes[middle](k);
  }
  return median;
}

}  // namespace

void writeRun(const PaperFigure& figure, const ObservationRun& run, std::ostream& out) {
  const std::vector<PaperMoment> moments =
      runPaperFilter(run, figure.start, figure.stated_stddev_rad);
  const Eigen::Vector3d truth = trueMount(run);
  out << std::setprecision(kDigits) << "time_s,distance_m,x_m,y_m";
  for (const char* what : {"estimate", "stddev", "bound", "truth"}) writeNames(out, what);
  out << '\n';
  for (const PaperMoment& moment : moments) {
    const Eigen::Vector2d& place = run.world_from_base[moment.observation].position_m;
    out << moment.time_s << ',' << moment.distance_m << ',' << place.x() << ',' << place.y();
    writeValues(out, truth + moment.error);
    writeValues(out, moment.stddev);
    writeValues(out, moment.bound);
    writeValues(out, truth);
    out << '\n';
  }
}

void RunStatistics::add(const std::vector<PaperMoment>& moments) {
  constexpr double kPrintedAngle_deg = 0.1;
  constexpr double kPrintedRho_mm = 1.0;
  constexpr double kLostSigmas = 5.0;
  if (sums_.empty()) sums_.resize(moments.size());
  ++runs_;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const PaperMoment& moment = moments[i];
    Sums& sums = sums_[i];
    sums.time_s += moment.time_s;
    sums.distance_m += moment.distance_m;
    sums.error2 += moment.error.cwiseAbs2();
    sums.variance += moment.stddev.cwiseAbs2();
    sums.bound2 += moment.bound.cwiseAbs2();
    sums.bound_unknown2 += moment.bound_unknown.cwiseAbs2();
    const Eigen::Vector3d size = moment.error.cwiseAbs();
    sums.sizes.push_back(size);
    const Eigen::Vector3d in_units = shown(size);
    const bool as_printed = in_units(0) < kPrintedAngle_deg && in_units(1) < kPrintedRho_mm &&
                            in_units(2) < kPrintedAngle_deg;
    sums.as_printed += as_printed ? 1 : 0;
    sums.lost += (size.array() < kLostSigmas * moment.stddev.array()).all() ? 0 : 1;
  }
}

void RunStatistics::write(std::ostream& out) const {
  out << std::setprecision(kDigits) << "time_s,distance_m,runs,as_printed_percent,lost_percent";
  for (const char* what : {"rmse", "median", "stddev", "bound", "bound_unknown"}) {
    writeNames(out, what);
  }
  out << '\n';
  for (const Sums& sums : sums_) {
    out << sums.time_s / runs_ << ',' << sums.distance_m / runs_ << ',' << runs_ << ','
        << 100.0 * sums.as_printed / runs_ << ',' << 100.0 * sums.lost / runs_;
    writeValues(out, (sums.error2 / runs_).cwiseSqrt());
    writeValues(out, medianOf(sums.sizes));
    for (const Eigen::Vector3d& sum : {sums.variance, sums.bound2, sums.bound_unknown2}) {
      writeValues(out, (sum / runs_).cwiseSqrt());
    }
    out << '\n';
  }
}

}  // namespace bearing_calibration::core
