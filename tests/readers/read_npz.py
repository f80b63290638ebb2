"""NumPy reads what is exported for it."""
import pathlib
import sys

import reference

try:
    import numpy as np
except ImportError:
    reference.skip("NumPy is not installed (apt-get install python3-numpy)")

folder = pathlib.Path(sys.argv[1])
data = np.load(folder / "m.npz")
positions, times = data["positions"], data["times"]
assert positions.dtype == np.float64 and positions.shape == (9, 63 + 61, 3), positions.shape
assert [float(t) for t in times] == [reference.time_of(k) for k in reference.FRAMES]  # to the bit
assert data["frames"].tolist() == list(reference.FRAMES) and data["frame_rate"] == reference.FRAME_RATE
first, corner = data["cloth_first_vertex"], data["cloth_first_triangle"]
assert [name.decode() for name in data["cloth_names"]] == ["front panel", "back"]
assert first.tolist() == [0, 63, 124] and corner.tolist() == [0, 96, 96 + 96]
for k in reference.FRAMES:
    for c, sheet in enumerate(reference.frame(folder, k)):
        own = slice(first[c], first[c + 1])
        assert np.array_equal(positions[k, own], np.array(sheet["v"])), k  # to the bit
        assert np.array_equal(data["triangles"][corner[c]:corner[c + 1]] - first[c], np.array(sheet["f"]))
        assert np.allclose(data["uv"][own], np.array(sheet["vt"]), atol=1e-6)
# Where a vertex goes in a frame is about what its velocity says: within a step's change of speed.
way = np.diff(positions, axis=0) * reference.FRAME_RATE
assert data["velocities"].shape == positions.shape
assert np.abs(way[:3] - data["velocities"][1:4]).max() < 9.81 / reference.FRAME_RATE
assert np.abs(data["velocities"][0]).max() == 0.0
part = np.load(folder / "part.npz")
assert part["frames"].tolist() == [3, 4, 5, 6] and np.array_equal(part["positions"], positions[3:7])
