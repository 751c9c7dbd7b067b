#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace voidpath::geom {

/// Model and printer space: millimetres, z up, right-handed.
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quaternion = Eigen::Quaterniond;

}  // namespace voidpath::geom
