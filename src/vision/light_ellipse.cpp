#include "bearing_calibration/vision/light_ellipse.h"

#include <cmath>

namespace bearing_calibration::core {

double axisError(const LightEllipse& ellipse) {
  const double difference = ellipse.radial_variance_px2 - ellipse.tangential_variance_px2;
  return 0.5 * std::atan2(2.0 * ellipse.mixed_variance_px2, std::abs(difference));
}

}  // namespace bearing_calibration::core
