#pragma once

#include <span>

#include <Eigen/Core>

#include "pled_vins/geometry/pose.hpp"

namespace pled {

/// The rigid transform T that minimises sum |to_i - T from_i|^2. Both of one length,
/// at least 1. Source: Umeyama, PAMI 1991, eqs. (40)-(42) with c = 1.
[[nodiscard]] Pose align_rigid(std::span<const Eigen::Vector3d> from,
                               std::span<const Eigen::Vector3d> to);

}  // namespace pled
