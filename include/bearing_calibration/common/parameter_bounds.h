#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

/// The bounds that a configuration declares, by the parameters' names. What depends on other
/// parameters (`that`) is none.
class Bounds : public Parameters {
 public:
  struct Range {
    double least;
    double most;
  };

  template <typename Config>
  explicit Bounds(Config config) {
    config.declare(*this);
  }

  const std::map<std::string, Range>& ranges() const { return ranges_; }
  const std::map<std::string, std::vector<std::string>>& choices() const { return choices_; }

 private:
  void between(const std::string& name, double /*value*/, double least, double most) override {
    Range& range = ranges_.try_emplace(name, Range{least, most}).first->second;
    range = {std::max(range.least, least), std::min(range.most, most)};
  }
  void oneOf(const std::string& name, const std::string& /*value*/,
             const std::vector<std::string>& names) override {
    choices_[name] = names;
  }

  std::map<std::string, Range> ranges_;
  std::map<std::string, std::vector<std::string>> choices_;
};

}  // namespace bearing_calibration::core
