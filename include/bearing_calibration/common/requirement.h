#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {

/// Collects one sentence for each broken requirement of a configuration, named by its parameter.
class Requirements {
 public:
  void that(bool holds, const std::string& sentence) {
    if (!holds) errors_.push_back(sentence);
  }
  void positive(const std::string& name, double value) {
    that(std::isfinite(value) && value > 0.0,
         name + " must be greater than 0, but is " + textOf(value));
  }
  void notNegative(const std::string& name, double value) {
    that(std::isfinite(value) && value >= 0.0,
         name + " must not be negative, but is " + textOf(value));
  }
  void between(const std::string& name, double value, double low, double high) {
    that(
        std::isfinite(value) && value >= low && value <= high,
        name + " must lie in [" + textOf(low) + ", " + textOf(high) + "], but is " + textOf(value));
  }
  void add(const std::vector<std::string>& errors) {
    errors_.insert(errors_.end(), errors.begin(), errors.end());
  }
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  static std::string textOf(double value) { return formatted("%.9g", value); }

  std::vector<std::string> errors_;
};

}  // namespace bearing_calibration::core
