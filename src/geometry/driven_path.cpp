#include "bearing_calibration/geometry/driven_path.h"

#include <stdexcept>

namespace bearing_calibration::core {

DrivenPath::DrivenPath(double spacing_m, std::size_t most_points)
    : first_spacing_m_(spacing_m), spacing_m_(spacing_m), most_points_(most_points) {
  if (!(spacing_m > 0.0) || most_points < 2) {
    throw std::invalid_argument("a path needs a spacing above 0 and room for two points");
  }
}

void DrivenPath::add(const Eigen::Vector2d& position_m) {
  if (!points_m_.empty() && (position_m - points_m_.back()).norm() < spacing_m_) return;
  if (points_m_.size() == most_points_) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points_m_.size(); i += 2) points_m_[kept++] = points_m_[i];
    points_m_.resize(kept);
    spacing_m_ *= 2.0;
  }
  points_m_.push_back(position_m);
}

void DrivenPath::clear() {
  points_m_.clear();
  spacing_m_ = first_spacing_m_;
}

}  // namespace bearing_calibration::core
