#pragma once
// Names shared by the whole simulation library.
//
// Units are SI: metre, kilogram, second, newton, pascal. y points up. A triangle's corners run
// counter-clockwise seen from the side its normal points to. A position vector q has shape (3n): vertex i
// stands at q.segment<3>(3 i).

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cloth {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat2 = Eigen::Matrix2d;
using Mat32 = Eigen::Matrix<double, 3, 2>;
using Mat3 = Eigen::Matrix3d;
using Mat4 = Eigen::Matrix4d;
using Vec9 = Eigen::Matrix<double, 9, 1>;
using Mat9 = Eigen::Matrix<double, 9, 9>;
using VecX = Eigen::VectorXd;
using VecRef = Eigen::Ref<const Eigen::VectorXd>;
/// Rows of three vertex indices, shape (m, 3).
using Triangles = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// Rows of points, shape (n, 3) [m].
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// Rows of texture coordinates u v, shape (n, 2): v upwards, an image covers 0 … 1.
using TexturePoints = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

}  // namespace cloth
