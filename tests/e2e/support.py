# SPDX-License-Identifier: Apache-2.0
"""What the end-to-end tests share: running the binary, reading what it wrote, a small city of our own.

ZONECAST names the binary; ZONECAST_DATA the folder of real city models (default: ../shared/data beside the sources).
Standard library only.
"""
import contextlib
import hashlib
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

BINARY = os.environ.get("ZONECAST", "")
SOURCES = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("ZONECAST_DATA") or SOURCES.parent / "shared" / "data")
PATH_HEADER = "time_s,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov_y_deg"
# Where Mesa keeps what it compiled, which takes it seconds a run: it would move with XDG_CACHE_HOME.
SHADER_CACHE = os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache"
SKIPPED = 77  # the exit code by which ctest knows a test that did not run
RSS_TOLERANCE_BYTES = 4 << 20
KERNEL = "packets64+texels"  # of replays that do not say: none is measured that is not under test


class Case(unittest.TestCase):
    """Each class has one folder of its own, removed at the end."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="zonecast-e2e-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.cache = cls.folder / "cache"  # instead of the user's
        cls.prepare()

    @classmethod
    def prepare(cls):
        pass

    @classmethod
    def run_zonecast(cls, *arguments, timeout_s=240, environment=()):
        words = [BINARY, *map(str, arguments)]
        if "replay" in arguments[:1] and "--kernel" not in arguments:
            words += ["--kernel", KERNEL]
        if arguments[:1] in (("bake",), ("replay",)) and "--progress" not in arguments:
            words += ["--progress", "none"]  # what long work says, on a slow machine, is not under test
        variables = {"MESA_SHADER_CACHE_DIR": str(SHADER_CACHE), **os.environ, "XDG_CACHE_HOME": str(cls.cache),
                     **dict(environment)}
        return subprocess.run(words, capture_output=True, text=True, errors="replace", timeout=timeout_s, check=False,
                              env=variables)

    @classmethod
    def zonecast(cls, *arguments, timeout_s=240):
        """A run that must succeed; its standard output."""
        done = cls.run_zonecast(*arguments, timeout_s=timeout_s)
        if done.returncode != 0:
            words = " ".join(map(str, arguments))
            raise AssertionError(f"zonecast {words}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout

    @classmethod
    def bake_small_city(cls, world, archive=None):
        """In zones of few triangles, and packed as well where `archive` says; its source is city.json."""
        write_small_city(cls.folder / "city.json")
        cls.zonecast("bake", cls.folder / "city.json", "--leaf-triangles", "64", "-o", world)
        if archive is not None:
            cls.zonecast("pack", world, "-o", archive)

    @classmethod
    def cap_for(cls, place, cap=8 << 20):
        """The cap under which cls.world pages from `place` as its folder does under `cap`: of an archive on a server the
        index is in memory, 24 bytes a file."""
        if "://" not in str(place) or not str(place).endswith(".3tz"):
            return cap
        return cap + 24 * sum(file.is_file() and file.name != "bake.cache" for file in cls.world.rglob("*"))

    @classmethod
    @contextlib.contextmanager
    def serve(cls, world, *options):
        """`zonecast serve` on a free port, until the block ends; its address. It must end well."""
        words = [BINARY, "serve", str(world), "--port", "0", *map(str, options)]
        with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
            try:
                line = server.stdout.readline()
                if " at http://" not in line:
                    raise AssertionError(f"{line}{server.stderr.read()}")
                yield line.split(" at ")[1].strip()
            finally:
                server.terminate()
                _, errors = server.communicate(timeout=30)
            if server.returncode != 0 or errors:
                raise AssertionError(f"serve: exit code {server.returncode}\n{errors}")

    def assert_memory_within_cap(self, stats):
        """What the kernel says of a replay without pictures, which the ledger has no part in.

        It is measured from when the source is open. Beyond the cap come pages of code that run for the first time and
        each worker's stack and arena of the allocator: 0.7 MiB with one worker, 1.4 MiB with four were measured.
        """
        held = stats["peak_rss_bytes"] - stats["baseline_rss_bytes"]
        self.assertGreater(held, 0)
        self.assertLessEqual(held, stats["cap_bytes"] + RSS_TOLERANCE_BYTES)

    def assert_refused(self, arguments, code, *parts):
        """The run ends with `code` and one line on standard error that holds `parts`, and touches no file."""
        before = snapshot(self.folder)
        done = self.run_zonecast(*arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        lines = done.stderr.splitlines()
        self.assertEqual(len(lines), 1, done.stderr)
        self.assertTrue(lines[0].startswith("zonecast: "), lines[0])
        for part in parts:
            self.assertIn(str(part), lines[0])
        self.assertEqual(snapshot(self.folder), before, "files were left behind or touched")
        return lines[0]


def main():
    """unittest's main, but skips are told apart from passes."""
    if not BINARY or not os.access(BINARY, os.X_OK):
        sys.exit("ZONECAST does not name the zonecast binary")
    program = unittest.main(exit=False, verbosity=2)
    result = program.result
    for test, reason in result.skipped:
        print(f"SKIPPED {test}: {reason}", file=sys.stderr)
    if not result.wasSuccessful():
        sys.exit(1)
    sys.exit(SKIPPED if result.skipped and len(result.skipped) >= result.testsRun else 0)


def snapshot(folder):
    """Every path below a folder, with the hash of what is in it."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        found[name] = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "folder"
    return found


def read_stats(out):
    return json.loads((out / "stats.json").read_text())["summary"]


def read_png(path):
    """(width, height, RGB bytes) of an 8-bit RGB PNG; every chunk's checksum is checked."""
    data = path.read_bytes()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise AssertionError(f"{path} is no PNG")
    at, packed, width, height = 8, b"", 0, 0
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        (crc,) = struct.unpack_from(">I", data, at + 8 + length)
        if crc != zlib.crc32(kind + body):
            raise AssertionError(f"{path}: chunk {kind} is damaged")
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlace = struct.unpack(">IIBBBBB", body)
            if (depth, color, interlace) != (8, 2, 0):
                raise AssertionError(f"{path} is not 8-bit RGB")
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    return width, height, unfilter(zlib.decompress(packed), width, height)


def write_png(path, width, height, rgb):
    """An 8-bit RGB PNG."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    rows = b"".join(b"\0" + rgb[3 * width * y : 3 * width * (y + 1)] for y in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) +
                     chunk(b"IEND", b""))


def unfilter(raw, width, height):
    row_bytes, out, above = 3 * width, bytearray(), bytearray(3 * width)
    for y in range(height):
        start = y * (row_bytes + 1)
        kind, row = raw[start], bytearray(raw[start + 1 : start + 1 + row_bytes])
        for x in range(row_bytes) if kind else ():
            left = row[x - 3] if x >= 3 else 0
            up = above[x]
            if kind == 1:
                guess = left
            elif kind == 2:
                guess = up
            elif kind == 3:
                guess = (left + up) // 2
            else:
                corner = above[x - 3] if x >= 3 else 0
                guess = min((left, up, corner), key=lambda v, p=left + up - corner: abs(p - v))
            row[x] = (row[x] + guess) & 255
        out += row
        above = row
    return bytes(out)


def rmse(a, b):
    """Root mean square difference of two pictures' values, 0 to 255."""
    if a[:2] != b[:2]:
        raise AssertionError(f"pictures of {a[:2]} and {b[:2]}")
    return math.sqrt(sum((x - y) ** 2 for x, y in zip(a[2], b[2])) / len(a[2]))


def colors(picture):
    return set(zip(*(picture[2][channel::3] for channel in range(3))))


def write_path(path, samples):
    """samples: (time_s, eye, target)."""
    rows = [PATH_HEADER]
    for time_s, eye, target in samples:
        rows.append(",".join(f"{v:.4f}" for v in (time_s, *eye, *target, 60)))
    path.write_text("\n".join(rows) + "\n")


def write_small_city(path, blocks=8):
    """CityJSON of blocks × blocks gabled houses with glass fronts on a road: many zones, baked in a moment."""
    vertices, objects = [], {}

    def corner(x, y, z):
        vertices.append([round(x * 1000), round(y * 1000), round(z * 1000)])
        return len(vertices) - 1

    def box_faces(x, y, width, depth, height):
        a, b, c, d = (corner(x + dx, y + dy, 0) for dx, dy in ((0, 0), (width, 0), (width, depth), (0, depth)))
        e, f, g, h = (corner(x + dx, y + dy, height) for dx, dy in ((0, 0), (width, 0), (width, depth), (0, depth)))
        i, j = corner(x, y + depth / 2, height + 3), corner(x + width, y + depth / 2, height + 3)
        walls = [[a, b, f, e], [b, c, g, j, f], [c, d, h, g], [d, a, e, i, h]]
        return walls + [[e, f, j, i], [g, h, i, j], [d, c, b, a]]

    for row in range(blocks):
        for column in range(blocks):
            height = 6 + (row * 7 + column * 3) % 11
            faces = box_faces(40 * column, 40 * row, 22, 18, height)
            kinds = [4, 0, 0, 0, 1, 1, 2]
            objects[f"house_{row}_{column}"] = solid("Building", "Solid", [[[face] for face in faces]], [kinds])
    side = 40 * blocks
    ground = [corner(x, y, 0) for x, y in ((-20, -20), (side, -20), (side, side), (-20, side))]
    objects["street"] = {
        "type": "Road",
        "geometry": [{"type": "MultiSurface", "lod": "1", "boundaries": [[ground]]}],
    }
    city = {
        "type": "CityJSON",
        "version": "2.0",
        "transform": {"scale": [0.001, 0.001, 0.001], "translate": [650000, 5400000, 300]},
        "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/25832"},
        "CityObjects": objects,
        "vertices": vertices,
    }
    path.write_text(json.dumps(city))
    return city


def solid(kind, geometry, boundaries, values):
    names = ["WallSurface", "RoofSurface", "GroundSurface", "Door", "Window"]
    semantics = {"surfaces": [{"type": name} for name in names], "values": values}
    return {
        "type": kind,
        "geometry": [{"type": geometry, "lod": "2", "boundaries": boundaries, "semantics": semantics}],
    }


def small_drive(path, samples=40, blocks=8, frames_per_s=10):
    """Down a street of write_small_city and back, between the houses."""
    length = 40 * blocks
    rows = []
    for i in range(samples):
        x = 650000 + length * i / samples
        rows.append((i / frames_per_s, (x, 5400029, 302), (x + 10, 5400028, 301.5)))
    write_path(path, rows)
