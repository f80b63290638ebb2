"""Simulates a small run and exports it in every format that there is: what the other tests here read.

make_exports.py PROGRAM FOLDER
"""
import pathlib
import shutil
import struct
import subprocess
import sys

import reference

SCENE = """
version = 1
[simulation]
frame_rate = 30
[[cloth]]
name = "front panel"
size = [0.5, 0.4]
resolution = [9, 7]
rotate = [-80.0, 0.0, 0.0]
translate = [0.0, 0.33, 0.0]
pattern = "tartan"
pattern_scale = 0.25
[[cloth]]
name = "back"
radius = 0.15
rings = 4
rotate = [90.0, 0.0, 0.0]
translate = [0.0, 0.45, 0.0]
[[collider]]
name = "ball"
radius = 0.15
path = [{ time = 0.0 }, { time = 0.2, translate = [0.1, 0.05, 0.0], rotate = [0.0, 40.0, 0.0] }]
[[collider]]
name = "block"
shape = "box"
center = [0.0, -0.6, 0.0]
[[collider]]
name = "leaf"
shape = "mesh"
mesh = "leaf.obj"
cache = "leaf.pc2"
cache_rate = 30.0
center = [2.0, 0.0, 0.0]
[[event]]
time = 0.1
collider = "block"
action = "off"
[camera]
path = [{ time = 0.0, position = [0.9, 0.8, 1.9] }, { time = 0.2, position = [1.2, 0.8, 1.7] }]
"""


def main(program, folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "small.toml").write_text(SCENE)
    leaf = [reference.leaf(k) for k in reference.FRAMES]
    (folder / "leaf.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in leaf[0]) + "f 1 2 3\nf 1 3 4\n")
    numbers = [number for frame in leaf for point in frame for number in point]
    (folder / "leaf.pc2").write_bytes(b"POINTCACHE2\0" + struct.pack("<iiffi", 1, 4, 0.0, 1.0, len(leaf)) +
                                      struct.pack(f"<{len(numbers)}f", *numbers))

    def run(*arguments):
        subprocess.run([program, *arguments, "--quiet"], cwd=folder, check=True, stdout=subprocess.DEVNULL)

    run("simulate", "--scene", "small.toml", "--frames", "9", "--out", "run")
    for name in ("m.obj", "m.ply", "m.glb", "m.gltf", "m.npz", "m.pvd", "m.usda"):
        run("export", "--out", "run", "--file", name)
    for name in ("front.obj", "front.pc2", "front.mdd"):
        run("export", "--out", "run", "--cloth", "front panel", "--file", name)
    run("export", "--out", "run", "--frames", "3:7", "--file", "part.npz")
    run("export", "--out", "run", "--frame", "5", "--file", "one.vtp")


if __name__ == "__main__":
    main(str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve())
