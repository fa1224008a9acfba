// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/placement.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace cholecystectomy {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double weight_of(const Replacement& organ) {
  return 1 / organ.replaced.spread.squaredNorm();
}

}  // namespace

Frame frame_of(std::span<const Vector3d> points) {
  Frame frame;
  const auto count = static_cast<double>(points.size());
  for (const Vector3d& p : points) {
    frame.centre += p / count;
  }
  Matrix3d covariance = Matrix3d::Zero();
  for (const Vector3d& p : points) {
    covariance += (p - frame.centre) * (p - frame.centre).transpose() / count;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(covariance);
  for (int i = 0; i < 3; ++i) {
    Vector3d axis = solver.eigenvectors().col(2 - i);
    double moment = 0;
    for (const Vector3d& p : points) {
      moment += std::pow((p - frame.centre).dot(axis), 3);
    }
    frame.axes.col(i) = moment < 0 ? Vector3d(-axis) : axis;
    frame.spread[i] = std::sqrt(std::max(0.0, solver.eigenvalues()[2 - i]));
  }
  frame.axes.col(2) = frame.axes.col(0).cross(frame.axes.col(1));
  return frame;
}

Eigen::Isometry3d fit_motion(std::span<const Replacement> organs) {
  Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
  double weight = 0;
  for (const Replacement& organ : organs) {
    from += weight_of(organ) * organ.own.centre;
    to += weight_of(organ) * organ.replaced.centre;
    weight += weight_of(organ);
  }
  from /= weight;
  to /= weight;
  Matrix3d correlation = Matrix3d::Zero();
  for (const Replacement& organ : organs) {
    const auto& [own, replaced] = organ;
    correlation += weight_of(organ) * (replaced.centre - to) * (own.centre - from).transpose();
    correlation += weight_of(organ) * replaced.axes *
                   replaced.spread.cwiseProduct(own.spread).asDiagonal() * own.axes.transpose();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d signs(1, 1, 1);
  signs[2] = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  motion.translation() = to - motion.linear() * from;
  return motion;
}

}  // namespace cholecystectomy
