"""VTK, which is what ParaView reads with, reads what is exported for it."""
import pathlib
import sys
import xml.etree.ElementTree

import reference

try:
    import numpy as np
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
except ImportError:
    reference.skip("VTK is not installed (apt-get install python3-vtk9 python3-numpy)")

folder = pathlib.Path(sys.argv[1])


def read(name):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(folder / name))
    reader.Update()
    assert reader.GetErrorCode() == 0, name
    return reader.GetOutput()


def array(of, name):
    return vtk_to_numpy(of.GetArray(name))


def triangles(mesh):
    return vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)


listed = xml.etree.ElementTree.parse(folder / "m.pvd").getroot().find("Collection").findall("DataSet")
cloths = [entry for entry in listed if entry.get("part") == "0"]
colliders = [entry for entry in listed if entry.get("part") == "1"]
assert len(cloths) == len(colliders) == 9
for k in reference.FRAMES:
    for entry in (cloths[k], colliders[k]):
        assert float(entry.get("timestep")) == reference.time_of(k)  # to the bit
    mesh = read(cloths[k].get("file"))
    assert array(mesh.GetFieldData(), "TimeValue").tolist() == [reference.time_of(k)]
    points, data = vtk_to_numpy(mesh.GetPoints().GetData()), mesh.GetPointData()
    sheets = reference.frame(folder, k)
    assert np.array_equal(points, np.vstack([sheet["v"] for sheet in sheets])), k  # to the bit
    assert np.array_equal(triangles(mesh), np.vstack([sheets[0]["f"], np.array(sheets[1]["f"]) + 63]))
    assert array(mesh.GetCellData(), "object").tolist() == [0] * 96 + [1] * 96
    assert np.allclose(array(data, "normal"), np.vstack([sheet["vn"] for sheet in sheets]), atol=1e-6)
    assert np.allclose(array(data, "uv"), np.vstack([sheet["vt"] for sheet in sheets]), atol=1e-6)
    assert array(data, "velocity").shape == (124, 3)
    assert array(data, "stretch").shape == array(data, "curvature").shape == (124,)
    if k == 0:
        assert np.allclose(array(data, "stretch"), 1.0, atol=1e-6)
        assert np.allclose(array(data, "curvature"), 0.0, atol=1e-4)
        # Of the ball and the block, whose top is 0.35 m under the ball's middle.
        gap = np.minimum(np.linalg.norm(points, axis=1) - 0.15, points[:, 1] + 0.35)
        assert np.allclose(array(data, "gap"), gap, atol=1e-6)
for k in reference.FRAMES:
    mesh = read(colliders[k].get("file"))
    leaf = vtk_to_numpy(mesh.GetPoints().GetData())[triangles(mesh)[array(mesh.GetCellData(), "object") == 2]]
    assert np.array_equal(leaf.reshape(-1, 3), np.array(reference.placed_leaf(k))), k  # to the bit
ball = [vtk_to_numpy(read(entry.get("file")).GetPoints().GetData()) for entry in colliders]
assert len(ball[0]) == len(ball[8]) + 36  # the corners of the block's triangles are gone
count = len(ball[8]) - len(reference.LEAF_CORNERS)
assert np.allclose(ball[8][:count].mean(axis=0) - ball[0][:count].mean(axis=0), [0.1, 0.05, 0.0], atol=5e-3)
one = read("one.vtp")
assert np.array_equal(vtk_to_numpy(one.GetPoints().GetData()),
                      np.vstack([sheet["v"] for sheet in reference.frame(folder, 5)]))
