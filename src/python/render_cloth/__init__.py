"""Cloth simulation and its pictures from Python.

    import render_cloth as rc
    scene = rc.load("drape_sphere", {"cloth.resolution": 40})
    sim = rc.Simulation(scene)
    for report in sim.frames(60):
        print(report["frame"], report["iterations"], sim.positions[:, 1].min())
    picture = rc.Renderer(scene).draw(sim.state)          # uint8, (height, width, 4)

Units are SI, y is up. Arrays are read-only views without a copy, and stay valid when what they came from is gone. What
the program would refuse or fail with is render_cloth.Error, in the program's own words. `python -m render_cloth` is the
program.
"""

import json as _json
import os as _os
from pathlib import Path as _Path

import numpy as _np


def _find_assets():
    """Tells the library where scenes are: it would look beside the program, which is Python here."""
    for parent in _Path(__file__).resolve().parents:
        for folder in (parent / "assets", parent / "share" / "render_cloth"):
            if (folder / "scenes").is_dir():
                _os.environ.setdefault("RENDER_CLOTH_ASSETS", str(folder))
                return


_find_assets()

from . import _core
from ._core import Error, Renderer, Scene, Simulation, State, build, scenes, version

__all__ = ["Error", "Renderer", "Run", "Scene", "Simulation", "State", "build", "load", "scenes", "version"]


def _toml(value):
    """A value as a scene file has it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _json.dumps(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(each)}" for key, each in value.items()) + " }"
    if hasattr(value, "tolist"):
        return _toml(value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(each) for each in value) + "]"
    return repr(value)


def load(name, settings=None):
    """A scene by its name or the path of its TOML file, with `settings` laid over it: a dict from keys such as
    "cloth.resolution" or "collider[1].radius" to values. Raises Error."""
    return _core._load(str(name), [f"{key}={_toml(value)}" for key, value in (settings or {}).items()])


def _frames(self, count):
    """Advances `count` frames and yields the report of each. Raises Error where a step does not converge."""
    for _ in range(count):
        report = self.advance()
        if not report["converged"]:
            raise Error(f"frame {self.frame + 1}: a step did not converge, not even cut into parts")
        yield report


def _hessian(self):
    """Of the energies' sum by the positions, a SciPy CSR matrix of shape (3n, 3n) [N/m]. Needs SciPy."""
    import scipy.sparse

    rows, columns, values = self._hessian()
    size = 3 * len(self.positions)
    return scipy.sparse.csr_matrix((values, (rows, columns)), shape=(size, size))


Simulation.frames = _frames
Simulation.hessian = _hessian


class Run:
    """A run that the program keeps in a folder. Raises Error where it holds none."""

    def __init__(self, folder):
        self._run = _core._Run(str(folder))
        self.folder = _Path(folder)

    @property
    def scene(self):
        return self._run.scene

    @property
    def frames(self):
        """Numbers of the frames whose state is kept."""
        return self._run.frames

    @property
    def triangles(self):
        """Corners of all triangles, shape (m, 3)."""
        return self._run.triangles

    def state(self, frame):
        """The kept State of a frame."""
        return self._run.state(frame)

    @property
    def positions(self):
        """Of all kept frames, shape (frames, n, 3) [m]."""
        return _np.stack([self.state(frame).positions for frame in self.frames])

    @property
    def certificate(self):
        """certificate.json: per frame its measures, and the verdict."""
        return _json.loads(self._run._certificate())

    @property
    def report(self):
        """report.json: how the run went."""
        return _json.loads(self._run._report())
