#!/usr/bin/env python3
"""A gripper picks a cloth up at one edge and folds it in two: pins that a program makes, moves and lets go while the
simulation runs. Writes one picture a frame, and a movie where ffmpeg is there.

    PYTHONPATH=build/release/python examples/gripper.py [FOLDER]
"""
import pathlib
import shutil
import subprocess
import sys

import numpy as np
import render_cloth as rc

SCENE = """
version = 1
description = "A gripper folds a napkin"

[simulation]
frame_rate = 30
substeps = 2

[[cloth]]
name = "napkin"
size = [0.5, 0.5]
resolution = [26, 26]
rotate = [-90.0, 0.0, 0.0]
translate = [0.0, 0.004, 0.0]
color = "#c9d6e8"
back_color = "#35598a"

[[collider]]
name = "table"
shape = "box"
size = [0.9, 0.04, 0.7]
center = [0.0, -0.02, 0.0]
friction = 0.6
color = "#8a6242"

[camera]
position = [0.55, 0.55, 0.85]
target = [0.0, 0.08, 0.0]
field_of_view = 32

[output]
size = [640, 480]
"""


def path(progress, start, end, height):
    """From start to end over an arc, at a share of the way."""
    smooth = progress * progress * (3 - 2 * progress)
    return (1 - smooth) * start + smooth * end + np.array([0, height * np.sin(np.pi * smooth), 0])


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "out/gripper")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "gripper.toml").write_text(SCENE)
    scene = rc.load(folder / "gripper.toml")
    simulation, renderer = rc.Simulation(scene), rc.Renderer(scene)

    settle, fold, rest = 8, 60, 20
    grip = None
    for frame in range(settle + fold + rest):
        if frame == settle:  # close the gripper on the two corners of the near edge
            x = simulation.positions
            corners = [int(np.argmin(x[:, 0] - x[:, 2])), int(np.argmax(x[:, 0] + x[:, 2]))]
            start = x[corners].copy()
            end = start * [1, 1, -0.92] + [0, 0.006, 0]  # onto the far edge
            grip = corners
        if grip and frame < settle + fold:
            progress = (frame - settle + 1) / fold
            simulation.hold(grip, [path(progress, a, b, 0.24) for a, b in zip(start, end)])
        if frame == settle + fold:
            simulation.release(grip)
        for report in simulation.frames(1):
            print(f"frame {report['frame']}: {report['iterations']} iterations, stretch {report['largest_stretch']:.3f}")
        picture = renderer.draw(simulation.state)
        height, width = picture.shape[:2]
        with open(folder / f"frame_{frame:06d}.ppm", "wb") as file:
            file.write(f"P6 {width} {height} 255\n".encode() + picture[:, :, :3].tobytes())
    if shutil.which("ffmpeg"):
        subprocess.run(["ffmpeg", "-y", "-loglevel", "error", "-framerate", "30", "-i", str(folder / "frame_%06d.ppm"),
                        "-pix_fmt", "yuv420p", str(folder / "gripper.mp4")], check=True)
        print(folder / "gripper.mp4")


if __name__ == "__main__":
    main()
