#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/light_bearings.h"

namespace bearing_calibration::core {

/// How a value of the optics is known.
enum class OpticsState : std::uint8_t {
  kConfigured,  ///< no light was seen yet
  kLearning,
  kLearnt,  ///< its standard deviation is at most half of the configured one
};
const char* nameOf(OpticsState state);

/// A value of the optics as a parameter.
struct LearntOptics {
  const char* parameter;
  const char* stddev_parameter;
  double value;   ///< [m], of the half angle [rad]
  double stddev;  ///< as its parameter: relative, of the half angle [rad]
  OpticsState state;
};

/// Lens and mirror as the light's own images show them: a Gaussian estimate, its prior what is
/// configured with its standard deviations (detection.md, "Optics learnt while driving"). What
/// moves azimuths is no part of it: the calibration estimates that.
class OpticsLearner {
 public:
  static constexpr int kValues =
      4;  ///< as in OpticsUncertainty: scale, aperture, focus, half angle

  /// @throws std::invalid_argument without a conic mirror
  explicit OpticsLearner(const DetectorConfig& configured);

  /// @returns whether it was used: one may come too soon after another, or not be as any of the
  ///   optics that are thought possible would show it
  bool add(const RangedSpot& spot);
  /// An image has no light where one is expected. After ten seconds of these, and of spots
  /// that do not fit, another lens or focus is likelier: it begins again with what is configured.
  void miss(Stamp stamp);
  /// One of the two, by what an image shows; neither where the prediction is of another moment, for
  /// nobody knows whether the light should be seen, or where it is one of several.
  /// @param lights  of the image, as the candidates of `bearings`
  void see(const std::vector<Detection>& lights, const BearingSet& bearings,
           const BearingPrediction& prediction);

  /// The configuration with lens and mirror as they are known now.
  DetectorConfig applied(DetectorConfig config) const;
  /// Whether they are known so much better than when this was last true that it is worth while to
  /// look with them.
  bool hasNews();

  std::array<LearntOptics, kValues> optics() const;
  int learntValues() const;
  /// Of what yamlOf() has written: as many of its values are learnt, against what is configured
  /// here.
  int learntValuesIn(const std::string& yaml) const;

 private:
  /// The optics' values, then what else decides how a light looks.
  static constexpr int kUnknowns = 11;
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;
  using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

  ConicMirror mirrorAt(const Vector& state) const;
  std::optional<Eigen::Vector3d> expected(const Vector& state, const RangedSpot& spot) const;
  bool update(const RangedSpot& spot);
  bool isSoon(Stamp stamp) const;
  void countUnlike(Stamp stamp);
  double stddevOf(int value) const;

  DetectorConfig configured_;
  Vector prior_mean_ = Vector::Zero();
  Vector prior_stddev_ = Vector::Zero();
  Vector mean_ = Vector::Zero();            ///< off the prior's, in its standard deviations
  Matrix covariance_ = Matrix::Identity();  ///< in the same units
  std::optional<Stamp> last_;               ///< that was looked at
  int used_ = 0;
  int unlike_ = 0;                     ///< in a row
  Vector said_mean_ = Vector::Zero();  ///< when there were news last
  Vector said_stddev_ = Vector::Ones();
};

/// The optics as a file of parameters for the detection's next start.
std::string yamlOf(const OpticsLearner& learner);

}  // namespace bearing_calibration::core
