#include "bearing_calibration/common/chi_square.h"

#include <boost/math/distributions/chi_squared.hpp>

namespace bearing_calibration::core {

double chiSquareQuantile(double probability, double degrees_of_freedom) {
  return boost::math::quantile(boost::math::chi_squared(degrees_of_freedom), probability);
}

double chiSquareExceededBy(double probability, double degrees_of_freedom) {
  return boost::math::quantile(
      boost::math::complement(boost::math::chi_squared(degrees_of_freedom), probability));
}

double chiSquareProbability(double value, double degrees_of_freedom) {
  return boost::math::cdf(boost::math::chi_squared(degrees_of_freedom), value);
}

}  // namespace bearing_calibration::core
