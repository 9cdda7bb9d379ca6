#!/usr/bin/env python3
"""Octrees exchanged with OctoMap's own library, both ways, leaf by leaf.

    pip install numpy octomap-python
    python tools/octomap_exchange.py [FILE.bt ...]

Ours to OctoMap: a map by FLAP's rules is written as .bt and .ot; OctoMap reads both and must find our leaves, and what it
writes of them must be our bytes. OctoMap to ours: trees that OctoMap built from scans and single updates, and the files given,
must have the same leaves when we read them, and the same bytes when we write them again. Exit status 1 at the first difference;
0 with a note where octomap-python is not installed.
"""
import argparse
import random
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CENTRE = 32768


def ours(*words):
    command = ["cargo", "run", "--release", "--quiet", "-p", "voxmap", "--example", "octree_exchange", "--", *map(str, words)]
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def parsed(text):
    """Leaves as {(x, y, z, level): (occupied, log-odds)}."""
    leaves = {}
    for line in text.splitlines():
        x, y, z, level, occupied, value = line.split(",")
        leaves[int(x), int(y), int(z), int(level)] = int(occupied), float(value)
    return leaves


def octomaps(tree):
    leaves = {}
    for leaf in tree.begin_leafs():
        level = tree.getTreeDepth() - leaf.getDepth()
        # The key of a leaf above the lowest level is that of its middle.
        key = leaf.getKey()
        low = [(int(key[a]) >> level << level) - CENTRE for a in range(3)]
        leaves[(*low, level)] = int(tree.isNodeOccupied(leaf)), leaf.getValue()
    return leaves


def body(path):
    """The nodes of a file: what follows its header."""
    data = Path(path).read_bytes()
    return data[data.index(b"data\n") + 5:]


def cells(leaves):
    """States of single cells: a .bt joins leaves that differ in value alone."""
    return {
        (x + i, y + j, z + k): occupied
        for (x, y, z, level), (occupied, _) in leaves.items()
        for i in range(1 << level) for j in range(1 << level) for k in range(1 << level)
    }


def compare(name, a, b, values):
    if set(a) != set(b):
        sys.exit(f"{name}: {len(set(a) ^ set(b))} leaves stand in one tree only, such as {sorted(set(a) ^ set(b))[:3]}")
    for leaf in a:
        if a[leaf][0] != b[leaf][0] or (values and abs(a[leaf][1] - b[leaf][1]) > 1e-6):
            sys.exit(f"{name}: leaf {leaf} is {a[leaf]} in one tree and {b[leaf]} in the other")
    print(f"{name}: {len(a)} leaves, {sum(o for o, _ in a.values())} occupied, the same in both")


def load(octomap, path):
    tree = octomap.OcTree(0.1)
    data = Path(path).read_bytes()
    if data.startswith(b"# Octomap OcTree binary"):
        assert tree.readBinary(str(path).encode()), path
        return tree
    return octomap.OcTree.read(str(path).encode())


def built(octomap, numpy, seed):
    """A tree from scans and single updates, on both sides of the origin."""
    random.seed(seed)
    tree = octomap.OcTree(0.05)
    for _ in range(6):
        origin = numpy.array([random.uniform(-1, 1) for _ in range(3)])
        points = numpy.array([[random.gauss(0, 2) for _ in range(3)] for _ in range(400)])
        tree.insertPointCloud(points, origin, maxrange=3.0)
    for _ in range(2000):
        tree.updateNode(numpy.array([random.uniform(-40, 40) for _ in range(3)]), random.random() < 0.5)
    # Whole cubes, which become leaves above the lowest level.
    for x in range(16):
        for y in range(16):
            for z in range(16):
                for _ in range(8):
                    tree.updateNode(numpy.array([5.0 + 0.05 * x, 0.025 + 0.05 * y, -0.775 + 0.05 * z]), False)
    tree.updateInnerOccupancy()
    return tree


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path)
    arguments = parser.parse_args()
    try:
        import numpy
        import octomap
    except ImportError as missing:
        print(f"SKIPPED: {missing}; pip install numpy octomap-python")
        return
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        ours("write", folder)
        wanted = parsed((folder / "ours.csv").read_text())
        for kind in ("bt", "ot"):
            file, back = folder / f"ours.{kind}", folder / f"back.{kind}"
            tree = load(octomap, file)
            if kind == "ot":
                compare("ours.ot read by OctoMap", wanted, octomaps(tree), True)
            elif cells(wanted) == cells(octomaps(tree)):
                print(f"ours.bt read by OctoMap: {len(cells(wanted))} cells, the same in both")
            else:
                sys.exit("ours.bt read by OctoMap: cells differ")
            (tree.writeBinary if kind == "bt" else tree.write)(str(back).encode())
            print(f"ours.{kind} written by OctoMap:", "the same bytes" if body(back) == body(file) else sys.exit("other bytes"))
        files = list(arguments.files)
        for seed in range(3):
            tree = built(octomap, numpy, seed)
            for kind in ("ot", "bt"):
                file = folder / f"octomap{seed}.{kind}"
                # Writing a .bt makes every value one of two, and joins leaves; so it comes last.
                (tree.writeBinary if kind == "bt" else tree.write)(str(file).encode())
                files.append(file)
        for file in files:
            again = folder / "again"
            read = parsed(ours("read", file.resolve(), again))
            tree = load(octomap, file)
            compare(f"{file.name} read by us", octomaps(tree), read, file.suffix == ".ot")
            print(f"{file.name} written by us:", "the same bytes" if body(again) == body(file) else sys.exit("other bytes"))
            compare(f"{file.name} written by us and read by OctoMap", octomaps(load_as(octomap, again, file)), read, file.suffix == ".ot")


def load_as(octomap, path, like):
    """OctoMap's tree of a file without an ending."""
    copy = path.with_suffix(like.suffix)
    copy.write_bytes(path.read_bytes())
    return load(octomap, copy)


if __name__ == "__main__":
    main()
