#pragma once

#include <cstdint>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "tools/paper/paper_experiment.h"

namespace bearing_calibration::core {

/// An experiment of the paper's section V.
struct PaperFigure {
  std::string name;         ///< of its files
  SimulatedCase simulated;  ///< its seed is that of the first run
  PaperStart start;
  double stated_stddev_rad = 0.0;  ///< of a bearing, as the filter takes it
};

/// Fig. 2 in the readings of "variance equal to 0.01 v dt", and Fig. 3; the last of them with
/// bearings as good as exact, whose bound is what the wheels alone leave.
std::vector<PaperFigure> simulatedFigures();

/// Fig. 5: the robot of the paper's experiment, its start, and a light that it drives around.
PaperFigure experimentFigure();

/// What a camera made of the lights in rendered images.
struct CameraRun {
  ObservationRun run;  ///< each observation with the variance that was measured over all of them
  int images = 0;
  int found = 0;
  double rms_error_rad = 0.0;
  double bias_rad = 0.0;
};

/// Renders each image of a run, looks for the light in it, and takes what is found for the bearing.
/// @param on_image  told how many images are done
CameraRun renderedRun(const PaperFigure& figure, const std::function<void(int)>& on_image);

ObservationRun simulatedRun(const PaperFigure& figure, std::uint64_t seed);

/// One run, moment by moment, as CSV.
void writeRun(const PaperFigure& figure, const ObservationRun& run, std::ostream& out);

/// Many runs of one figure at the same moments: errors, what the filter says of them and the
/// bounds.
class RunStatistics {
 public:
  /// In any order: call it for one run after the other in the order of the seeds, and the sums are
  /// the same to the last digit.
  void add(const std::vector<PaperMoment>& moments);
  void write(std::ostream& out) const;

 private:
  struct Sums {
    double time_s = 0.0;
    double distance_m = 0.0;
    Eigen::Vector3d error2 = Eigen::Vector3d::Zero();
    Eigen::Vector3d variance = Eigen::Vector3d::Zero();
    Eigen::Vector3d bound2 = Eigen::Vector3d::Zero();
    Eigen::Vector3d bound_unknown2 = Eigen::Vector3d::Zero();
    std::vector<Eigen::Vector3d> sizes;  ///< of the errors
    int as_printed = 0;                  ///< runs as good as the paper says of its Fig. 3
    int lost = 0;  ///< runs with an error of more than five of its own standard deviations
  };
  std::vector<Sums> sums_;
  int runs_ = 0;
};

}  // namespace bearing_calibration::core
