#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <tuple>

#include "bearing_calibration/filter/tilted_observation.h"
#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/odometry/odometry_increment.h"

// What may be wrong with a robot, as blocks of numbers that are estimated beside the mount; all of
// them are zero for a robot as it is believed (model.md, "The imperfect robot"). A block is one
// small type below, and its place in the list `ErrorBlocks` at the end: nothing else names it.
// `kLasts` says of each number whether it is the same when the robot starts anew.

namespace bearing_calibration::core {

inline constexpr int kMostLights = 8;

/// A number's name, and its unit: "1" for a ratio.
struct Quantity {
  const char* name;
  const char* unit;
};

/// A motion while the blocks correct it one after the other; K errors.
template <int K>
struct CorrectedMotion {
  Pose2 start_from_end;
  Eigen::Matrix<double, 3, K> J_pose_errors = Eigen::Matrix<double, 3, K>::Zero();
};

/// A light, by the base at a bearing's stamp, while the blocks move it to where the sensor saw it.
template <int K>
struct CorrectedLight {
  Eigen::Vector2d in_base;
  Eigen::Matrix2d J_light_light = Eigen::Matrix2d::Identity();
  Eigen::Matrix<double, 2, K> J_light_errors = Eigen::Matrix<double, 2, K>::Zero();
};

/// An azimuth while the blocks bend it.
template <int K>
struct CorrectedAzimuth {
  int light = 0;
  double azimuth_rad = 0.0;
  double range_m = 0.0;          ///< from the sensor to the light
  double J_azimuth_ideal = 1.0;  ///< by the azimuth of a sensor without errors
  double J_azimuth_range = 0.0;
  Eigen::Matrix<double, 1, K> J_azimuth_errors = Eigen::Matrix<double, 1, K>::Zero();
};

/// A light's elevation over the sensor's plane, for the blocks to say.
template <int K>
struct CorrectedElevation {
  int light = 0;
  double azimuth_rad = 0.0;  ///< of a sensor without errors
  double range_m = 0.0;      ///< from the sensor to the light
  double elevation_rad = 0.0;
  double J_elevation_ideal = 0.0;  ///< by azimuth_rad
  double J_elevation_range = 0.0;
  Eigen::Matrix<double, 1, K> J_elevation_errors = Eigen::Matrix<double, 1, K>::Zero();
};

/// What the wheels' blocks say that a wheel has rolled, for other blocks to use.
struct WheelFactors {
  double left = 1.0;
  double right = 1.0;
  double separation = 1.0;
};

/// A block without any effect: what each one below changes, it says anew. `q` is the block's own
/// part of the errors, `At` its place among them.
struct NoEffect {
  static constexpr bool kSaidBySensor = false;  ///< see ErrorBlockInfo
  template <class Q>
  static void addTo(WheelFactors&, const Q& /*q*/) {}
  template <int At, class Q, int K>
  static void correct(CorrectedMotion<K>&, const OdometryIncrement&, const Q& /*q*/) {}
  template <int At, class Q, int K>
  static void correct(CorrectedLight<K>&, const OdometryWindow&, const WheelFactors&,
                      const Q& /*q*/) {}
  template <int At, class Q, int K>
  static void correct(CorrectedAzimuth<K>&, const Q& /*q*/) {}
  template <int At, class Q, int K>
  static void correct(CorrectedElevation<K>&, const Q& /*q*/) {}
};

/// The bearings' stamps are late against the encoders' by this [s].
struct TimeOffset : NoEffect {
  static constexpr const char* kName = "time_offset";
  static constexpr std::array<Quantity, 1> kNumbers = {{{"time_offset", "s"}}};
  static constexpr int kSize = 1;
  static constexpr std::array<double, 1> kPriorWeights = {1.0};
  static constexpr std::array<bool, 1> kLasts = {false};
  static constexpr const char* kWhenHeld =
      "the stamps' offset is as configured: only turns of changing speed determine it";

  using NoEffect::correct;
  /// The base was where the wheels put it q seconds before the stamp (model.md, eq. 16).
  template <int At, class Q, int K>
  static void correct(CorrectedLight<K>& light, const OdometryWindow& nearby,
                      const WheelFactors& wheels, const Q& q) {
    const WheelDisplacement travel = nearby.travelTo(-q(0));
    const WheelSpeeds speeds = nearby.speedsAt(-q(0));
    const double separation_m = nearby.wheelSeparation() * wheels.separation;
    const Pose2 moment_from_stamp =
        arcFromWheels({wheels.left * travel.left_m, wheels.right * travel.right_m}, separation_m)
            .start_from_end.inverse();
    const double left_mps = wheels.left * speeds.left_mps;
    const double right_mps = wheels.right * speeds.right_mps;
    light.in_base = moment_from_stamp * light.in_base;
    light.J_light_light = rotation2(moment_from_stamp.yaw_rad);
    light.J_light_errors.col(At) =
        Eigen::Vector2d(0.5 * (left_mps + right_mps), 0.0) +
        (right_mps - left_mps) / separation_m * perpendicular(light.in_base);
  }
};

/// Each wheel rolls (1 + q) times what its counter and radius say.
struct WheelScales : NoEffect {
  static constexpr const char* kName = "wheel_scales";
  static constexpr std::array<Quantity, 2> kNumbers = {
      {{"left_wheel_scale", "1"}, {"right_wheel_scale", "1"}}};
  static constexpr int kSize = 2;
  static constexpr std::array<double, 2> kPriorWeights = {1.0, 1.0};
  static constexpr std::array<bool, 2> kLasts = {true, true};
  static constexpr const char* kWhenHeld =
      "the wheels' radii are as configured: longer drives and more turns determine them";

  template <class Q>
  static void addTo(WheelFactors& wheels, const Q& q) {
    wheels.left += q(0);
    wheels.right += q(1);
  }
  using NoEffect::correct;
  /// model.md, eq. 17.
  template <int At, class Q, int K>
  static void correct(CorrectedMotion<K>& motion, const OdometryIncrement& measured, const Q& q) {
    const auto J = measured.J_pose_wheels.leftCols<kSize>();
    const Eigen::Vector3d change = J * q;
    motion.start_from_end.position_m += change.head<2>();
    motion.start_from_end.yaw_rad = wrapAngle(motion.start_from_end.yaw_rad + change(2));
    motion.J_pose_errors.template middleCols<kSize>(At) = J;
  }
};

/// The wheels are (1 + q) times as far apart as believed. Bearings and wheels alone cannot tell: it
/// is what their lengths are measured by.
struct WheelSeparation : NoEffect {
  static constexpr const char* kName = "wheel_separation";
  static constexpr std::array<Quantity, 1> kNumbers = {{{"wheel_separation_scale", "1"}}};
  static constexpr int kSize = 1;
  static constexpr std::array<double, 1> kPriorWeights = {1.0};
  static constexpr std::array<bool, 1> kLasts = {true};
  static constexpr const char* kWhenHeld =
      "the metric scale of all lengths is your wheel separation: measure it well";

  template <class Q>
  static void addTo(WheelFactors& wheels, const Q& q) {
    wheels.separation += q(0);
  }
  using NoEffect::correct;
  /// model.md, eq. 18. The turn is exact, the chord to first order: over many metres a wrong
  /// turn is what counts.
  template <int At, class Q, int K>
  static void correct(CorrectedMotion<K>& motion, const OdometryIncrement& measured, const Q& q) {
    const auto J = measured.J_pose_wheels.rightCols<kSize>();
    // the whole turn with what the wheels' blocks before this one have put right
    const double turn =
        -J(2) + wrapAngle(motion.start_from_end.yaw_rad - measured.start_from_end.yaw_rad);
    const double factor = 1.0 / (1.0 + q(0));
    motion.start_from_end.position_m += J.template topRows<2>() * q;
    motion.start_from_end.yaw_rad =
        wrapAngle(motion.start_from_end.yaw_rad + turn * (factor - 1.0));
    motion.J_pose_errors.row(2) *= factor;
    motion.J_pose_errors.template block<2, 1>(0, At) = J.template topRows<2>();
    motion.J_pose_errors(2, At) = -turn * factor * factor;
  }
};

/// Mirror axis, apex and image centre are not on one line: the azimuth is off by a first harmonic
/// of the sizes q(0), q(1) [rad] for a far light, and by q(2) [m] over the range times these more
/// for a near one. q(2) is a constant of mirror and lens (optics/conic_mirror) where the
/// image's centre is put as that says, and known beforehand (model.md, eq. 19).
struct MirrorHarmonic : NoEffect {
  static constexpr const char* kName = "mirror_harmonic";
  static constexpr bool kSaidBySensor = true;
  static constexpr std::array<Quantity, 3> kNumbers = {{{"mirror_harmonic_cos", "rad"},
                                                        {"mirror_harmonic_sin", "rad"},
                                                        {"mirror_near_per_far", "m"}}};
  static constexpr int kSize = 3;
  static constexpr int kNearPerFar = 2;  ///< place of that number in it
  static constexpr std::array<double, 3> kPriorWeights = {1.0, 1.0, 0.0};
  static constexpr std::array<bool, 3> kLasts = {true, true, true};
  static constexpr const char* kWhenHeld =
      "a tilted mirror has the effect of a shifted camera: drive at several distances from the "
      "light";

  using NoEffect::correct;
  template <int At, class Q, int K>
  static void correct(CorrectedAzimuth<K>& azimuth, const Q& q) {
    const double c = std::cos(azimuth.azimuth_rad);
    const double s = std::sin(azimuth.azimuth_rad);
    constexpr double kLeastRange_m = 0.05;  // nearer, the light stands over the mirror
    const double nearness = 1.0 / std::max(azimuth.range_m, kLeastRange_m);
    const double factor = 1.0 + q(kNearPerFar) * nearness;
    const double by_range = -q(kNearPerFar) * nearness * nearness;
    const double J_bent_straight = 1.0 - q(0) * factor * s + q(1) * factor * c;
    azimuth.J_azimuth_ideal *= J_bent_straight;
    azimuth.J_azimuth_errors *= J_bent_straight;
    azimuth.J_azimuth_range =
        J_bent_straight * azimuth.J_azimuth_range + q(0) * by_range * c + q(1) * by_range * s;
    azimuth.azimuth_rad += q(0) * factor * c + q(1) * factor * s;
    azimuth.J_azimuth_errors.template segment<kSize>(At) << factor * c, factor * s,
        nearness * (q(0) * c + q(1) * s);
  }
};

/// The sensor is rolled by q(0) and pitched by q(1) [rad], and light i stands q(2 + i) [m] over it
/// (model.md, eqs. 20 and 21). Azimuths of one light cannot tell that from a shifted mount. A
/// state has the heights of its own lights only.
struct SensorTilt : NoEffect {
  static constexpr const char* kName = "sensor_tilt";
  static constexpr int kHeights = 2;  ///< place of the first light's height in it
  static constexpr int kSize = kHeights + kMostLights;
  static constexpr std::array<Quantity, kSize> kNumbers = {{{"sensor_roll", "rad"},
                                                            {"sensor_pitch", "rad"},
                                                            {"light_height", "m"},
                                                            {"light_height_2", "m"},
                                                            {"light_height_3", "m"},
                                                            {"light_height_4", "m"},
                                                            {"light_height_5", "m"},
                                                            {"light_height_6", "m"},
                                                            {"light_height_7", "m"},
                                                            {"light_height_8", "m"}}};
  /// With 2 deg goes a light up to a third of a metre above or below.
  static constexpr std::array<double, kSize> kPriorWeights = {1.0,  1.0,  10.0, 10.0, 10.0,
                                                              10.0, 10.0, 10.0, 10.0, 10.0};
  static constexpr std::array<bool, kSize> kLasts = {true, true};
  static constexpr const char* kWhenHeld =
      "a tilted sensor has the effect of a shifted one: bearings with elevations distinguish them, "
      "after turns at several distances";

  using NoEffect::correct;
  template <int At, class Q, int K>
  static void correct(CorrectedAzimuth<K>& azimuth, const Q& q) {
    if (q.template head<kHeights>().isZero(0.0) && q(kHeights + azimuth.light) == 0.0)
      return;  // neither the azimuth nor its Jacobian is another
    const TiltedAngle tilted = tiltedAzimuth(levelObservation(azimuth, q));
    azimuth.azimuth_rad = tilted.angle_rad;
    azimuth.J_azimuth_ideal *= tilted.J_angle_level(0);
    azimuth.J_azimuth_range = tilted.J_angle_level(1);
    setJacobian<At>(tilted, azimuth.light, &azimuth.J_azimuth_errors);
  }
  template <int At, class Q, int K>
  static void correct(CorrectedElevation<K>& elevation, const Q& q) {
    const TiltedAngle tilted = tiltedElevation(levelObservation(elevation, q));
    elevation.elevation_rad = tilted.angle_rad;
    elevation.J_elevation_ideal = tilted.J_angle_level(0);
    elevation.J_elevation_range = tilted.J_angle_level(1);
    setJacobian<At>(tilted, elevation.light, &elevation.J_elevation_errors);
  }

 private:
  template <class Corrected, class Q>
  static LevelObservation levelObservation(const Corrected& observation, const Q& q) {
    const double height_m = q(kHeights + observation.light);
    return {observation.azimuth_rad, observation.range_m, height_m, q(0), q(1)};
  }
  template <int At, class Row>
  static void setJacobian(const TiltedAngle& tilted, int light, Row* J_angle_errors) {
    constexpr int kRoll = 2;  // place in a level observation
    J_angle_errors->template segment<kHeights>(At) = tilted.J_angle_level.segment<kHeights>(kRoll);
    (*J_angle_errors)(At + kHeights + light) = tilted.J_angle_level(kRoll + kHeights);
  }
};

/// Every block, in the order of their numbers in the state. An estimate has the shortest beginning
/// of this list that holds all blocks in use: the most used ones come first. Light passes the
/// blocks of the sensor from the last one to the first.
using ErrorBlocks =
    std::tuple<TimeOffset, WheelScales, WheelSeparation, MirrorHarmonic, SensorTilt>;

namespace detail {
template <class... Blocks>
constexpr int sizeOf(std::tuple<Blocks...>*) {
  return (0 + ... + Blocks::kSize);
}
}  // namespace detail

/// All numbers of all blocks.
inline constexpr int kErrorCount = detail::sizeOf(static_cast<ErrorBlocks*>(nullptr));
using ErrorVector = Eigen::Matrix<double, kErrorCount, 1>;
using ErrorMatrix = Eigen::Matrix<double, kErrorCount, kErrorCount>;

/// Place of a block's first number among all of them.
template <class Block, std::size_t I = 0>
constexpr int placeOf() {
  using Candidate = std::tuple_element_t<I, ErrorBlocks>;
  if constexpr (std::is_same_v<Block, Candidate>) {
    return 0;
  } else {
    return Candidate::kSize + placeOf<Block, I + 1>();
  }
}

/// Calls work(block, place) for each block that begins before `end`, in their order or from the
/// last one to the first.
template <std::size_t I = 0, int At = 0, class Work>
void forEachBlock(const Work& work, int end = kErrorCount, bool backwards = false) {
  if constexpr (I < std::tuple_size_v<ErrorBlocks>) {
    if (At >= end) return;
    using Block = std::tuple_element_t<I, ErrorBlocks>;
    if (!backwards) work(Block(), std::integral_constant<int, At>());
    forEachBlock<I + 1, At + Block::kSize>(work, end, backwards);
    if (backwards) work(Block(), std::integral_constant<int, At>());
  }
}

/// A block's part of all errors.
template <class Block, int At>
auto partOf(const ErrorVector& errors, Block, std::integral_constant<int, At>) {
  return errors.segment<Block::kSize>(At);
}

}  // namespace bearing_calibration::core
