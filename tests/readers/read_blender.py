"""Blender reads OBJ, PLY, PC2, MDD and glTF. Run by Python it starts Blender, which runs it once more."""
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import reference  # noqa: E402


def start(folder):
    blender = shutil.which("blender")
    if blender is None:
        reference.skip("Blender is not installed (apt-get install blender)")
    command = [blender, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1", "--python", __file__]
    done = subprocess.run([*command, "--", folder], capture_output=True, text=True)
    print(done.stdout, done.stderr)
    assert done.returncode == 0 and "all was read" in done.stdout


def read(folder):
    import bpy
    import numpy as np

    def stage():
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.context.scene.render.fps = int(reference.FRAME_RATE)

    def seen(name, k):
        """World positions as they are drawn at a frame."""
        bpy.context.scene.frame_set(k)
        drawn = bpy.data.objects[name]
        mesh = drawn.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
        return np.array([drawn.matrix_world @ vertex.co for vertex in mesh.vertices])

    def near(a, b, *about):
        far = np.abs(np.asarray(a) - np.asarray(b)).max()
        assert far <= reference.TOLERANCE, (far, *about)

    def y_up(points):
        """Blender's z-up importers turn a file's y to z."""
        return np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=1)

    def sheet_of(mesh, sheet, about):
        assert [list(face.vertices) for face in mesh.polygons] == sheet["f"], about
        uv = mesh.uv_layers[0].data
        corners = [corner for face in sheet["f"] for corner in face]
        near([uv[i].uv for i in range(len(corners))], [sheet["vt"][corner] for corner in corners], about)

    # OBJ: an object a cloth
    for k in (0, 8):
        stage()
        bpy.ops.wm.obj_import(filepath=str(folder / f"m_{k:06d}.obj"), forward_axis="Y", up_axis="Z")
        for sheet in reference.frame(folder, k):
            near(seen(sheet["name"], 0), sheet["v"], "obj", k)
            sheet_of(bpy.data.objects[sheet["name"]].data, sheet, "obj")
    # PLY: both as one
    stage()
    bpy.ops.import_mesh.ply(filepath=str(folder / "m_000008.ply"))
    near(seen(bpy.context.selected_objects[0].name, 0),
         np.vstack([sheet["v"] for sheet in reference.frame(folder, 8)]), "ply")
    # PC2 and MDD, over the first frame's mesh
    for kind in ("pc2", "mdd"):
        stage()
        bpy.ops.wm.obj_import(filepath=str(folder / "front_000000.obj"), forward_axis="Y", up_axis="Z")
        modifier = bpy.data.objects["front panel"].modifiers.new("cache", "MESH_CACHE")
        modifier.cache_format = kind.upper()
        modifier.filepath = str(folder / f"front.{kind}")
        modifier.frame_start = 0
        for k in reference.FRAMES:
            near(seen("front panel", k), reference.frame(folder, k)[0]["v"], kind, k)
    # glTF: at a frame rate of 30 its keys are whole frames
    for name in ("m.glb", "m.gltf"):
        stage()
        bpy.ops.import_scene.gltf(filepath=str(folder / name), import_shading="SMOOTH")
        for k in reference.FRAMES:
            for sheet in reference.frame(folder, k):
                near(y_up(seen(sheet["name"], k)), sheet["v"], name, k)
            near(y_up(seen("leaf", k)), reference.placed_leaf(k), name, "leaf", k)
        for sheet in reference.frame(folder, 0):
            mesh = bpy.data.objects[sheet["name"]].data
            sheet_of(mesh, sheet, name)
            curve = mesh.shape_keys.animation_data.action.fcurves[0]
            times = [point.co[0] / reference.FRAME_RATE for point in curve.keyframe_points]
            near(times, [reference.time_of(k) for k in reference.FRAMES], "times")
        ball = y_up(np.array([bpy.data.objects["ball"].location]))[0]
        near(ball, [0.1, 0.05, 0.0], "ball")  # after the last frame
        assert max(bpy.data.objects["block"].scale) == 0.0  # switched off at 0.1 s
        assert bpy.data.objects["camera"].type == "CAMERA"
    print("all was read")


if "bpy" in sys.modules or "--" in sys.argv:
    read(pathlib.Path(sys.argv[sys.argv.index("--") + 1]))
else:
    start(sys.argv[1])
