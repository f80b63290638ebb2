"""What the exports are compared with: the OBJ files, which have every digit, read by Python alone."""
import sys

FRAME_RATE = 30.0
FRAMES = range(9)
TOLERANCE = 1e-6  # [m]; that of the formats whose numbers are floats


def leaf(k):
    """A collider that bends, before it is moved by LEAF_CENTER: exact in floats."""
    return [(0.0, 0.0, 0.0), (0.5, 0.125 * k, 0.0), (0.5, 0.125 * k, -0.5), (0.0, 0.0, -0.5)]


LEAF_CENTER = (2.0, 0.0, 0.0)
LEAF_CORNERS = (0, 1, 2, 0, 2, 3)  # its triangles have corners of their own


def placed_leaf(k):
    return [[p + c for p, c in zip(leaf(k)[i], LEAF_CENTER)] for i in LEAF_CORNERS]


def skip(what):
    """CTest shows the test as skipped."""
    print("skipped: " + what)
    sys.exit(77)


def objects(path):
    """Of each object of an OBJ its name, vertices, texture coordinates, normals, and corners from 0."""
    found, before = [], 0
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            word, _, rest = line.rstrip("\n").partition(" ")
            if word == "o":
                before += len(found[-1]["v"]) if found else 0
                found.append({"name": rest, "v": [], "vt": [], "vn": [], "f": []})
            elif word in ("v", "vt", "vn"):
                found[-1][word].append([float(number) for number in rest.split()])
            elif word == "f":
                corners = [corner.split("/") for corner in rest.split()]
                assert all(len(set(corner)) == 1 for corner in corners), line
                found[-1]["f"].append([int(corner[0]) - 1 - before for corner in corners])
    return found


def frame(folder, k, stem="m"):
    return objects(folder / f"{stem}_{k:06d}.obj")


def time_of(k):
    return k / FRAME_RATE
