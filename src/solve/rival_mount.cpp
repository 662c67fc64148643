#include "bearing_calibration/solve/rival_mount.h"

#include "bearing_calibration/common/symmetric.h"

namespace bearing_calibration::core {

bool isAnotherMount(const MountEstimate& rival, const MountEstimate& mount) {
  constexpr double kAgreement = 16.3;  // chi-square that one right answer in a thousand has
  // what it would be on the average
  return chiSquareOf(mountDifference(rival.mean, mount.mean), mount.covariance) +
             solved(mount.covariance, rival.covariance).trace() >
         kAgreement;
}

double disagreement(const MountEstimate& a, const MountEstimate& b) {
  return chiSquareOf(mountDifference(a.mean, b.mean), a.covariance + b.covariance);
}

}  // namespace bearing_calibration::core
