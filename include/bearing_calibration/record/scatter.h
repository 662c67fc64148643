#pragma once

#include <cstddef>

namespace bearing_calibration::core {

/// How much the mounts scatter that the earlier and the later part of a drive tell, wherever it is
/// divided: as much as their covariances say, or something is wrong that no noise model knows
/// (bearings correlated over seconds, tyres that change, a floor that drags).
///
/// The pull at a jump of the mount (mount_displacement.h) is, over a record, a Brownian bridge in
/// three dimensions, so that the mean of its squares, each over its own variance, is an
/// Anderson-Darling statistic summed over three dimensions: 3 on the average when all is well. The
/// largest of those squares tells what has changed at one moment.
struct Scatter {
  double gain_sum = 0.0;  ///< of jumps (DisplacementTest::gain), chi-square of 3 degrees
  double largest_gain = 0.0;
  std::size_t observations = 0;  ///< before which the jump is told in all three directions
  int parts_given_away = 0;      ///< of the record, that are among them

  Scatter& operator+=(const Scatter& other);
  /// Adds that of a part of the record that is given away.
  void giveAway(const Scatter& part);
  /// 3 when all is well; 0 where no jump is told.
  double meanGain() const;
  /// How many times larger than stated the mount's covariance is, as the mean has it or as the
  /// largest one has it. 1 unless chance gives so much in one record of a hundred: honest robots
  /// must not pay.
  double widening() const;
};

}  // namespace bearing_calibration::core
