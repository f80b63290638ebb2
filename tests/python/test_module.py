"""The Python module, used as its readers would: what it gives agrees with the program, and what it refuses it refuses in
the program's words. Needs PYTHONPATH and RENDER_CLOTH (the program)."""
import gc
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np
import render_cloth as rc

PROGRAM = os.environ["RENDER_CLOTH"]
SMALL = {"cloth.resolution": 10, "output.size": [96, 64]}


class Module(unittest.TestCase):
    def test_steps_are_the_programs(self):
        """States to the bit, by the run that the program keeps."""
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([PROGRAM, "--scene", "hanging_sheet", "--frames", "6", "--out", folder + "/run", "--quiet",
                            "--no-video", "--set", "cloth.resolution=10", "--size", "96x64"], check=True, capture_output=True)
            run = rc.Run(folder + "/run")
            self.assertEqual(run.frames, list(range(6)))
            simulation = rc.Simulation(rc.load("hanging_sheet", SMALL), threads=1)
            for report in simulation.frames(5):
                kept = run.state(report["frame"])
                self.assertEqual(simulation.positions.tobytes(), kept.positions.tobytes())
                self.assertEqual(simulation.velocities.tobytes(), kept.velocities.tobytes())
            self.assertEqual(run.positions.shape, (6, 100, 3))
            self.assertEqual(run.certificate["verdict"], "good")
            self.assertEqual(len(run.report["frames"]), 6)
            np.testing.assert_array_equal(run.triangles, simulation.triangles)
            # The picture is the program's, pixel by pixel.
            picture = rc.Renderer(run.scene).draw(run.state(5))
            self.assertEqual((picture.shape, picture.dtype), ((64, 96, 4), np.uint8))
            raw = subprocess.run(["ffmpeg", "-loglevel", "error", "-i", folder + "/run/frames/frame_000005.png", "-f", "rawvideo",
                                  "-pix_fmt", "rgb24", "-"], check=True, capture_output=True).stdout
            self.assertEqual(picture[:, :, :3].tobytes(), raw)

    def test_arrays(self):
        simulation = rc.Simulation(rc.load("hanging_sheet", SMALL))
        first = simulation.positions
        before = first.copy()
        self.assertFalse(first.flags.writeable)
        self.assertIsNotNone(first.base)  # a view
        with self.assertRaises(ValueError):
            first[0, 0] = 1.0
        simulation.advance()
        self.assertTrue((simulation.positions != before).any())
        del simulation
        gc.collect()
        np.testing.assert_array_equal(first, before)  # valid, and what it was

    def test_restore_resumes_exactly(self):
        scene = rc.load("hanging_sheet", SMALL)
        simulation = rc.Simulation(scene)
        list(simulation.frames(3))
        state = simulation.state
        list(simulation.frames(2))
        end = simulation.positions.copy()
        other = rc.Simulation(scene)
        other.restore(state)
        self.assertEqual(other.frame, 3)
        list(other.frames(2))
        self.assertEqual(other.positions.tobytes(), end.tobytes())
        with self.assertRaisesRegex(ValueError, "does not belong to this scene"):
            other.restore(rc.Simulation(rc.load("hanging_sheet", {"cloth.resolution": 5})).state)

    def test_positions_can_be_set(self):
        simulation = rc.Simulation(rc.load("drape_sphere", SMALL))
        simulation.positions = simulation.positions + [0, 1, 0]
        simulation.velocities = np.tile([0, 2.0, 0], (100, 1))
        simulation.step()
        self.assertGreater(simulation.velocities[:, 1].min(), 1.7)
        with self.assertRaisesRegex(ValueError, r"positions needs the shape \(100, 3\)"):
            simulation.positions = np.zeros((99, 3))
        with self.assertRaisesRegex(ValueError, "not finite"):
            simulation.positions = np.full((100, 3), np.nan)

    def test_hold_and_release(self):
        simulation = rc.Simulation(rc.load("drape_sphere", {**SMALL, "collider[0].enabled": False}))
        place = simulation.positions[[0, 9]] + [[0, 0.01, 0], [0, 0.01, 0]]
        simulation.hold([0, 9], place)
        simulation.advance()
        np.testing.assert_array_equal(simulation.positions[[0, 9]], place)
        list(simulation.frames(3))
        np.testing.assert_array_equal(simulation.positions[[0, 9]], place)
        simulation.release([9])
        list(simulation.frames(3))
        np.testing.assert_array_equal(simulation.positions[0], place[0])
        self.assertLess(simulation.positions[9, 1], place[1][1] - 1e-3)
        simulation.release()
        list(simulation.frames(3))
        self.assertLess(simulation.positions[0, 1], place[0][1] - 1e-3)
        for vertices, places, words in (([100], [[0, 0, 0]], "vertex 100 does not exist; there are 100"),
                                        ([1, 2], [[0, 0, 0]], "2 vertices and 1 places"),
                                        ([1], [[0, np.inf, 0]], "not finite")):
            with self.assertRaisesRegex(ValueError, words):
                simulation.hold(vertices, places)

    def test_energies_and_derivatives(self):
        simulation = rc.Simulation(rc.load("hanging_sheet", SMALL))
        list(simulation.frames(4))
        x = simulation.positions.copy()
        energy = lambda: sum(simulation.energies().values())
        g = simulation.gradient()
        self.assertIn("membrane", simulation.energies())
        rng = np.random.default_rng(1)
        way, h = rng.normal(size=x.shape), 1e-7
        values = []
        for sign in (1, -1):
            simulation.positions = x + sign * h * way
            values.append((energy(), simulation.gradient()))
        slope = (values[0][0] - values[1][0]) / (2 * h)
        self.assertAlmostEqual(slope / np.sum(g * way), 1.0, places=4)
        simulation.positions = x
        try:
            hessian = simulation.hessian()
        except ModuleNotFoundError:
            print("no SciPy here: Hessians are not looked at")
            return
        change = (values[0][1] - values[1][1]) / (2 * h)
        np.testing.assert_allclose(hessian @ way.ravel(), change.ravel(), rtol=1e-4, atol=1e-4 * np.abs(change).max())
        self.assertLess(abs(hessian - hessian.T).max(), 1e-12 * abs(hessian).max())

    def test_errors_are_the_programs(self):
        with self.assertRaisesRegex(rc.Error, "unknown scene \"drape\"") as caught:
            rc.load("drape")
        self.assertEqual(caught.exception.code, 3)
        with self.assertRaisesRegex(rc.Error, "cloth.resolution"):
            rc.load("drape_sphere", {"cloth.resolution": 1})
        with self.assertRaisesRegex(rc.Error, "no run"):
            rc.Run("/nonexistent")
        for key, value in (("simulation.gravity", [0, -1.5, 0]), ("cloth.fabric", {"base": "silk", "friction": 0.4}),
                           ("collider[0].enabled", False), ("camera.frame", "auto"), ("cloth.size", np.array([0.5, 0.25]))):
            rc.load("drape_sphere", {key: value})

    def test_other_threads_run_while_it_computes(self):
        simulation = rc.Simulation(rc.load("drape_sphere", {"cloth.resolution": 40, "output.size": [96, 64]}))
        list(simulation.frames(6))
        count, stop = [0], threading.Event()

        def tick():
            while not stop.is_set():
                count[0] += 1
                stop.wait(1e-4)

        thread = threading.Thread(target=tick)
        thread.start()
        list(simulation.frames(6))
        stop.set()
        thread.join()
        self.assertGreater(count[0], 20)

    def test_the_program_is_the_module(self):
        done = subprocess.run([sys.executable, "-m", "render_cloth", "list", "--json"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual({s["name"] for s in json.loads(done.stdout)}, {name for name, _ in rc.scenes()})

    def test_the_gripper_folds(self):
        example = pathlib.Path(__file__).resolve().parents[2] / "examples" / "gripper.py"
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, str(example), folder], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue((pathlib.Path(folder) / "frame_000087.ppm").is_file())


if __name__ == "__main__":
    unittest.main()
