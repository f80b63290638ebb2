"""Pixar's library reads USD, where it is there: Debian has no reader of it."""
import pathlib
import sys

import reference

try:
    import numpy as np
    from pxr import Usd, UsdGeom, UsdShade
except ImportError:
    reference.skip("no reader of USD is installed (Python's module pxr)")

folder = pathlib.Path(sys.argv[1])
stage = Usd.Stage.Open(str(folder / "m.usda"))
assert UsdGeom.GetStageUpAxis(stage) == "Y" and UsdGeom.GetStageMetersPerUnit(stage) == 1.0
for c, name in enumerate(("front_panel", "back")):
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/" + name))
    samples = mesh.GetPointsAttr().GetTimeSamples()
    rate = stage.GetTimeCodesPerSecond()
    assert [code / rate for code in samples] == [reference.time_of(k) for k in reference.FRAMES]  # to the bit
    for k in reference.FRAMES:
        sheet = reference.frame(folder, k)[c]
        points, normals = mesh.GetPointsAttr().Get(k), mesh.GetNormalsAttr().Get(k)
        assert np.abs(np.array(points) - np.array(sheet["v"])).max() <= reference.TOLERANCE
        assert np.allclose(np.array(normals), np.array(sheet["vn"]), atol=1e-6)
    assert list(mesh.GetFaceVertexIndicesAttr().Get()) == [i for face in sheet["f"] for i in face]
    uv = UsdGeom.PrimvarsAPI(mesh.GetPrim()).GetPrimvar("st").Get()
    assert np.allclose(np.array(uv), np.array(sheet["vt"]), atol=1e-6)
    bound = UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()[0]
    assert str(bound.GetPath()) == "/World/Materials/" + name
leaf = UsdGeom.Mesh(stage.GetPrimAtPath("/World/leaf"))
for k in reference.FRAMES:
    moved = np.array(leaf.GetPointsAttr().Get(k))
    assert np.abs(moved - np.array(reference.placed_leaf(k))).max() <= reference.TOLERANCE
ball, block = (UsdGeom.Mesh(stage.GetPrimAtPath("/World/" + name)) for name in ("ball", "block"))
placed = ball.ComputeLocalToWorldTransform(8).ExtractTranslation()
assert np.allclose(np.array(placed), [0.1, 0.05, 0.0], atol=1e-9)
assert block.ComputeVisibility(0) == "inherited" and block.ComputeVisibility(8) == "invisible"
camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/camera")).GetCamera(0)
assert abs(camera.GetFieldOfView(camera.FOVVertical) - 35.0) < 1e-4
