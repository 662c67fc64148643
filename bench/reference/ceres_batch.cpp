#include "bench/reference/ceres_batch.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/init/closed_form.h"

namespace bearing_calibration::core::reference {
namespace {

/// The angle's representative in [-pi, pi], for numbers with derivatives.
template <typename T>
T wrapped(const T& angle) {
  return angle - T(2.0 * kPi) * floor((angle + T(kPi)) / T(2.0 * kPi));
}

/// Bearing of `light` from a sensor mounted at `mount` (x, y, yaw) on a base at `pose` (x, y, yaw).
template <typename T>
T azimuthOf(const T* light, const T* pose, const T* mount) {
  const T c = cos(pose[2]);
  const T s = sin(pose[2]);
  const T dx = light[0] - pose[0];
  const T dy = light[1] - pose[1];
  return atan2(-s * dx + c * dy - mount[1], c * dx + s * dy - mount[0]) - mount[2];
}

struct BearingResidual {
  double azimuth_rad;
  double weight;  ///< 1 / standard deviation

  template <typename T>
  bool operator()(const T* light, const T* pose, const T* mount, T* residual) const {
    residual[0] = T(weight) * wrapped(T(azimuth_rad) - azimuthOf(light, pose, mount));
    return true;
  }
};

struct FixedPoseBearingResidual {
  BearingResidual bearing;
  Pose2 first_from_base;

  template <typename T>
  bool operator()(const T* light, const T* mount, T* residual) const {
    const T pose[3] = {T(first_from_base.position_m.x()), T(first_from_base.position_m.y()),
                       T(first_from_base.yaw_rad)};
    return bearing(light, pose, mount, residual);
  }
};

struct MotionResidual {
  Pose2 start_from_end;
  Eigen::Matrix3d root;  ///< of the information

  template <typename T>
  bool operator()(const T* from, const T* to, T* residual) const {
    const T c = cos(from[2]);
    const T s = sin(from[2]);
    const T dx = to[0] - from[0];
    const T dy = to[1] - from[1];
    const Eigen::Matrix<T, 3, 1> error(c * dx + s * dy - T(start_from_end.position_m.x()),
                                       -s * dx + c * dy - T(start_from_end.position_m.y()),
                                       wrapped(to[2] - from[2] - T(start_from_end.yaw_rad)));
    Eigen::Map<Eigen::Matrix<T, 3, 1>>(residual).noalias() = root.cast<T>() * error;
    return true;
  }
};

ceres::LossFunction* makeLoss(double huber_sigmas) {
  return huber_sigmas > 0.0 ? new ceres::HuberLoss(huber_sigmas) : nullptr;
}

CeresAnswer solve(ceres::Problem* problem, ceres::LinearSolverType solver,
                  CeresTolerance tolerance) {
  constexpr int kMaxIterations = 200;
  constexpr double kTight = 1e-15;
  ceres::Solver::Options options;
  options.linear_solver_type = solver;
  options.num_threads = 1;
  options.max_num_iterations = kMaxIterations;
  options.logging_type = ceres::SILENT;
  if (tolerance == CeresTolerance::kTight) {
    options.function_tolerance = kTight;
    options.gradient_tolerance = kTight;
    options.parameter_tolerance = kTight;
  }
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  CeresAnswer answer;
  answer.cost = 2.0 * summary.final_cost;
  answer.iterations = static_cast<int>(summary.iterations.size());
  answer.converged = summary.termination_type == ceres::CONVERGENCE;
  return answer;
}

/// Of three unknowns; zero where the others leave them undetermined.
Eigen::Matrix3d covarianceOf(const double* unknowns, ceres::Problem* problem) {
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::SPARSE_QR;
  ceres::Covariance covariance(options);
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> block;
  const std::vector<std::pair<const double*, const double*>> wanted = {{unknowns, unknowns}};
  if (!covariance.Compute(wanted, problem)) return Eigen::Matrix3d::Zero();
  covariance.GetCovarianceBlock(unknowns, unknowns, block.data());
  return block;
}

BearingResidual residualOf(double azimuth_rad, double variance_rad2) {
  return {azimuth_rad, 1.0 / std::sqrt(variance_rad2)};
}

}  // namespace

BatchConfig costAlone(double huber_sigmas) {
  BatchConfig config = BatchConfig::leastSquares();
  config.huber_sigmas = huber_sigmas;
  return config;
}

CeresAnswer estimateByCeres(const std::vector<Observation>& observations, const RecordStart& start,
                            double huber_sigmas, CeresTolerance tolerance,
                            CeresCovariance covariance) {
  const std::vector<PosedObservation> posed = poseObservations(observations);
  std::vector<std::array<double, 3>> poses;
  for (const PosedObservation& observation : posed) {
    const Pose2& pose = observation.first_from_base;
    poses.push_back({pose.position_m.x(), pose.position_m.y(), pose.yaw_rad});
  }
  Eigen::Vector2d light =
      posed[start.observation].first_from_base * Eigen::Vector2d(start.lights_in_base.col(0));
  Eigen::Vector3d mount = start.mount;

  ceres::Problem problem;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<BearingResidual, 1, 2, 3, 3>(new BearingResidual(
            residualOf(observations[i].azimuth_rad, observations[i].azimuth_variance_rad2))),
        makeLoss(huber_sigmas), light.data(), poses[i].data(), mount.data());
    if (i == 0) continue;
    const Eigen::Matrix3d L = observations[i].motion.covariance.llt().matrixL();
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<MotionResidual, 3, 3, 3>(new MotionResidual{
            observations[i].motion.start_from_end,
            L.triangularView<Eigen::Lower>().solve(Eigen::Matrix3d::Identity())}),
        nullptr, poses[i - 1].data(), poses[i].data());
  }
  problem.SetParameterBlockConstant(poses.front().data());
  CeresAnswer answer = solve(&problem, ceres::SPARSE_NORMAL_CHOLESKY, tolerance);
  if (covariance == CeresCovariance::kMount) {
    answer.mount_covariance = covarianceOf(mount.data(), &problem);
  }
  const std::array<double, 3>& last = poses.back();
  const Pose2 first_from_last{{last[0], last[1]}, last[2]};
  answer.state << first_from_last.inverse() * light, mount.head<2>(), wrapAngle(mount(2));
  return answer;
}

CeresAnswer fitOnFixedPathByCeres(const std::vector<PosedObservation>& observations,
                                  const Vector5& start, double huber_sigmas,
                                  CeresTolerance tolerance) {
  Eigen::Vector2d light = start.head<2>();
  Eigen::Vector3d mount = start.tail<3>();
  ceres::Problem problem;
  for (const PosedObservation& observation : observations) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<FixedPoseBearingResidual, 1, 2, 3>(
            new FixedPoseBearingResidual{
                residualOf(observation.azimuth_rad, observation.azimuth_variance_rad2),
                observation.first_from_base}),
        makeLoss(huber_sigmas), light.data(), mount.data());
  }
  CeresAnswer answer = solve(&problem, ceres::DENSE_QR, tolerance);
  answer.state << light, mount.head<2>(), wrapAngle(mount(2));
  return answer;
}

CeresAnswer findStartByCeres(const std::vector<PosedObservation>& observations, int starts,
                             double huber_sigmas) {
  CeresAnswer best;
  for (int i = 0; i < starts; ++i) {
    const double yaw = 2.0 * kPi * i / starts;
    const double direction = yaw + observations.front().azimuth_rad;
    Vector5 start;
    start << std::cos(direction), std::sin(direction), 0.0, 0.0, yaw;
    const CeresAnswer answer =
        fitOnFixedPathByCeres(observations, start, huber_sigmas, CeresTolerance::kDefault);
    if (i == 0 || answer.cost < best.cost) best = answer;
  }
  return best;
}

}  // namespace bearing_calibration::core::reference
