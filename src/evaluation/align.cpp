#include "pled_vins/evaluation/align.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

Eigen::Vector3d mean(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

}  // namespace

Pose align_rigid(std::span<const Eigen::Vector3d> from, std::span<const Eigen::Vector3d> to) {
  PLED_CHECK(!from.empty() && from.size() == to.size());
  const Eigen::Vector3d from_mean = mean(from);
  const Eigen::Vector3d to_mean = mean(to);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    covariance += (to[i] - to_mean) * (from[i] - from_mean).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  // S of eq. (43): the weakest direction is turned round when U V^T would mirror.
  Eigen::Vector3d s = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) s.z() = -1.0;
  const Eigen::Matrix3d R = svd.matrixU() * s.asDiagonal() * svd.matrixV().transpose();
  Pose T;
  T.q = Eigen::Quaterniond(R).normalized();
  T.p = to_mean - T.q * from_mean;
  return T;
}

}  // namespace pled
