#pragma once
// Where the camera is at a time.
//
// Between the keys of a path each coordinate follows a cubic whose slopes are those of Fritsch and Butland
// 1984 (A method for constructing local monotone piecewise cubic interpolants): smooth, through every key,
// and never beyond two neighbouring ones. It starts and ends at rest, and stays there before and after. The
// turntable then turns the eye about the target.

#include <vector>

#include "pipeline/scene_file/picture_desc.h"
#include "render/frame.h"
#include "sim/algebra/types.h"

namespace cloth::pipeline {

struct CameraPose {
    Vec3 position, target;
    double field_of_view;  ///< [degree]
};
CameraPose camera_at(const CameraDesc& camera, double time);
/// Whether the pose depends on the time.
bool moves(const CameraDesc& camera);

/// Puts the camera's pose at `time` into `view`.
void aim(render::View& view, const CameraDesc& camera, double time);

/// Of all points that are to be in the picture, what decides where the camera must be.
class Extent {
  public:
    /// `aspect`: a picture's width over its height.
    Extent(const CameraDesc& camera, double aspect);
    void add(const Vec3& point);
    /// All points of another extent of the same camera and aspect.
    void add(const Extent& other);
    bool empty() const { return !(low_.x() <= high_.x()); }
    double diagonal() const { return empty() ? 0.0 : (high_ - low_).norm(); }  ///< of their box [m]

    /// `camera` moved, looking the same way, so that its picture holds all points with a twelfth of it to
    /// spare on each side. With a turntable the middle of their box becomes the target, and they fit in every
    /// turn; for this the furthest of them in many directions stand for all, which is right to a hundredth or
    /// so.
    CameraDesc framed(const CameraDesc& camera) const;

  private:
    Mat3 axes_;        ///< rows: right, up, forward
    Vec2 slopes_;      ///< half width and half height that may be used, over the depth
    Vec3 low_, high_;  ///< of the points' box [m]
    bool turns_;
    std::vector<Vec3> furthest_;  ///< where it turns: the point furthest in each of many directions [m]
    Vec2 most_,
        least_;  ///< greatest of x - slope z and -x - slope z, and of the same with y, in these axes [m]
};

}  // namespace cloth::pipeline
