#include "tools/paper/observability_ranks.h"

#include <Eigen/Core>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <optional>
#include <unsupported/Eigen/AutoDiff>

#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

constexpr int kMaxUnknowns = 15;  // X_a and all blocks
using Derivatives = Eigen::Matrix<double, kMaxUnknowns, 1>;
using Dual = Eigen::AutoDiffScalar<Derivatives>;
using Dual2 = std::array<Dual, 2>;

constexpr double kWheelSeparation_m = 0.25;
constexpr double kMountX_m = 0.08;
constexpr double kMountY_m = 0.05;
constexpr double kMountYaw_rad = 1.05;
constexpr double kLightHeight_m = 0.4;
constexpr double kSecondLightX_m = -0.6;
constexpr double kSecondLightY_m = 1.7;
constexpr double kSamplePeriod_s = 0.0973;  // meets no segment's end, where a late bearing has none
/// Singular values below this share of the largest are rounding: those that count are above 1e-6.
constexpr double kNeglected = 1e-10;

/// Light and mount as the bearing sees them, and everything else that is unknown.
struct World {
  Dual2 light{0.0, 0.0};
  std::optional<Dual2> second_light;
  Dual2 mount{kMountX_m, kMountY_m};
  Dual mount_yaw = kMountYaw_rad;
  Dual left_scale = 1.0;
  Dual right_scale = 1.0;
  Dual separation = kWheelSeparation_m;
  Dual time_offset_s = 0.0;
  Dual2 harmonic{0.0, 0.0};
  Dual2 tilt{0.0, 0.0};
  Dual height = kLightHeight_m;
};

/// Numbers the unknowns in the order in which they are declared.
class Numbering {
 public:
  Dual operator()(double value) { return Dual(value, kMaxUnknowns, next_++); }
  int count() const { return next_; }

 private:
  int next_ = 0;
};

Dual2 rotated(const Dual2& v, const Dual& angle) {
  const Dual c = cos(angle);
  const Dual s = sin(angle);
  return {c * v[0] - s * v[1], s * v[0] + c * v[1]};
}

/// The light at the origin of a world in which the base starts at (x, y, heading).
Dual2 lightInBase(const Dual& x, const Dual& y, const Dual& heading) {
  return rotated({-x, -y}, -heading);
}

void setPolarMount(World* world, Numbering& unknown) {
  const Dual phi = unknown(std::atan2(kMountY_m, kMountX_m));
  const Dual rho = unknown(std::hypot(kMountX_m, kMountY_m));
  world->mount = {rho * cos(phi), rho * sin(phi)};
  world->mount_yaw = phi + unknown(kMountYaw_rad - phi.value());
}

void setParametrisation(const ObservabilityCase& observed, World* world, Numbering& unknown) {
  const double x = observed.light_x_m;
  const double y = observed.light_y_m;
  constexpr double kHeading_rad = 0.4;  // of the base in X_a's world: any
  switch (observed.parametrisation) {
    case Parametrisation::kCartesian:
      world->light = {unknown(x), unknown(y)};
      world->mount = {unknown(kMountX_m), unknown(kMountY_m)};
      world->mount_yaw = unknown(kMountYaw_rad);
      return;
    case Parametrisation::kPaper: {
      const Dual distance = unknown(std::hypot(x, y));
      const Dual theta = unknown(-std::atan2(-y, -x));
      world->light = rotated({-distance, Dual(0.0)}, -theta);
      setPolarMount(world, unknown);
      return;
    }
    case Parametrisation::kPaperAugmented: {
      const double c = std::cos(kHeading_rad);
      const double s = std::sin(kHeading_rad);
      const Dual base_x = unknown(-(c * x - s * y));
      const Dual base_y = unknown(-(s * x + c * y));
      world->light = lightInBase(base_x, base_y, unknown(kHeading_rad));
      setPolarMount(world, unknown);
      return;
    }
  }
}

void setBlock(Unknown block, World* world, Numbering& unknown) {
  switch (block) {
    case Unknown::kWheelScales:
      world->left_scale = unknown(1.0);
      world->right_scale = unknown(1.0);
      return;
    case Unknown::kWheelSeparation:
      world->separation = unknown(kWheelSeparation_m);
      return;
    case Unknown::kTimeOffset:
      world->time_offset_s = unknown(0.0);
      return;
    case Unknown::kFirstHarmonic:
      world->harmonic = {unknown(0.0), unknown(0.0)};
      return;
    case Unknown::kTilt:
      world->tilt = {unknown(0.0), unknown(0.0)};
      return;
    case Unknown::kLightHeight:
      world->height = unknown(kLightHeight_m);
      return;
    case Unknown::kSecondLight:
      world->second_light = {unknown(kSecondLightX_m), unknown(kSecondLightY_m)};
      return;
  }
}

Dual sinc(const Dual& x) {
  constexpr double kSeries = 1e-3;  // below, two terms are exact to rounding
  if (std::abs(x.value()) < kSeries) return 1.0 - x * x / 6.0;
  return sin(x) / x;
}

/// Pose of the base in the frame of its start.
struct DualPose {
  Dual2 position{0.0, 0.0};
  Dual yaw = 0.0;
};

/// One exact arc (model.md, eq. 2).
DualPose moved(const DualPose& from, const DriveSegment& segment, const Dual& time_s,
               const World& world) {
  const Dual left = world.left_scale * segment.left_mps * time_s;
  const Dual right = world.right_scale * segment.right_mps * time_s;
  const Dual turn = (right - left) / world.separation;
  const Dual chord = 0.5 * (left + right) * sinc(0.5 * turn);
  const Dual2 step = rotated({chord, Dual(0.0)}, from.yaw + 0.5 * turn);
  return {{from.position[0] + step[0], from.position[1] + step[1]}, from.yaw + turn};
}

/// (azimuth, elevation) of a light from a base at `pose`. The tilt is of first order: a small
/// rotation about the sensor's x and y axes.
Dual2 observationOf(const Dual2& light, const DualPose& pose, const World& world) {
  const Dual2 in_base =
      rotated({light[0] - pose.position[0], light[1] - pose.position[1]}, -pose.yaw);
  const Dual2 level =
      rotated({in_base[0] - world.mount[0], in_base[1] - world.mount[1]}, -world.mount_yaw);
  const Dual x = level[0] + world.tilt[1] * world.height;
  const Dual y = level[1] - world.tilt[0] * world.height;
  const Dual z = world.height - world.tilt[1] * level[0] + world.tilt[0] * level[1];
  const Dual azimuth = atan2(y, x);
  const Dual range = sqrt(x * x + y * y);
  return {azimuth + world.harmonic[0] * cos(azimuth) + world.harmonic[1] * sin(azimuth),
          atan2(z, range)};
}

std::vector<Derivatives> jacobianOf(const ObservabilityCase& observed, const World& world) {
  std::vector<Derivatives> rows;
  DualPose begin;
  double next_s = 0.5 * kSamplePeriod_s;
  for (const DriveSegment& segment : observed.segments) {
    for (; next_s < segment.duration_s; next_s += kSamplePeriod_s) {
      const DualPose pose = moved(begin, segment, next_s - world.time_offset_s, world);
      const Dual2 observation = observationOf(world.light, pose, world);
      rows.push_back(observation[0].derivatives());
      if (world.second_light) {
        rows.push_back(observationOf(*world.second_light, pose, world)[0].derivatives());
      }
      if (observed.with_elevation) rows.push_back(observation[1].derivatives());
    }
    next_s -= segment.duration_s;
    begin = moved(begin, segment, Dual(segment.duration_s), world);
  }
  return rows;
}

/// Columns to length 1, so that the unknowns' units do not matter; what is rounding stays so.
void scaleColumns(Eigen::MatrixXd& J) {
  const double largest = J.colwise().norm().maxCoeff();
  for (Eigen::Index column = 0; column < J.cols(); ++column) {
    if (J.col(column).norm() > kNeglected * largest) J.col(column).normalize();
  }
}

}  // namespace

ObservabilityRank rankOf(const ObservabilityCase& observed) {
  World world;
  Numbering unknown;
  setParametrisation(observed, &world, unknown);
  for (Unknown block : observed.unknowns) setBlock(block, &world, unknown);

  const std::vector<Derivatives> rows = jacobianOf(observed, world);
  Eigen::MatrixXd J(static_cast<Eigen::Index>(rows.size()), unknown.count());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    J.row(static_cast<Eigen::Index>(i)) = rows[i].head(unknown.count()).transpose();
  }
  scaleColumns(J);
  const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(J).singularValues();
  ObservabilityRank result;
  result.unknowns = unknown.count();
  result.rank = static_cast<int>((values.array() > kNeglected * values(0)).count());
  result.least_counted = values(result.rank - 1) / values(0);
  if (result.rank < values.size()) result.most_neglected = values(result.rank) / values(0);
  return result;
}

std::string observabilityTable(const std::vector<ObservabilityCase>& cases) {
  std::string table =
      "| motion, state | rank | of | least counted | most neglected |\n|---|---|---|---|---|\n";
  for (const ObservabilityCase& observed : cases) {
    const ObservabilityRank found = rankOf(observed);
    table += formatted("| %s | %d | %d | %.0e | %.0e |%s\n", observed.motion.c_str(), found.rank,
                       found.unknowns, found.least_counted, found.most_neglected,
                       found.rank == observed.expected_rank ? "" : " not as expected");
  }
  return table;
}

}  // namespace bearing_calibration::core
