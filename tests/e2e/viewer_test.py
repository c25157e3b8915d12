# SPDX-License-Identifier: Apache-2.0
"""Worlds in browsers: what three.js and CesiumJS show is where the replay shows it.

A picture that differs is kept in out/viewer_test, with the replay's depth and a map: white both, red the browser alone,
blue the replay alone.
"""
import json
import shutil
import unittest

import node
import support

SIZE = (480, 270)
# No surface has it, and neither viewer changes it.
BACKGROUND = (255, 0, 255)
VIEWERS = ("three", "cesium")
# Share of the pixels with something in either picture that have something in both. Measured: 0.9994 and more; what is
# left lies on edges, which two rasterizers round apart.
MIN_OVERLAP = 0.99
KEPT = support.SOURCES / "out" / "viewer_test"
INGOLSTADT = support.DATA / "ingolstadt"


def silhouette(picture, background):
    rgb = picture[2]
    return [rgb[i : i + 3] != bytes(background) for i in range(0, len(rgb), 3)]


class Viewers(support.Case):
    @classmethod
    def prepare(cls):
        node.install()
        shutil.rmtree(KEPT, ignore_errors=True)

    def bake(self, name, source, *more):
        """Light is left out: no file that a viewer opens has any."""
        world = self.folder / name
        self.zonecast("bake", source, "--no-light", "-o", world, *more)
        return world

    def assert_alike(self, world, path, address=None):
        """Silhouettes of every camera of a path in all viewers, which read the world from there, against the replay's depth."""
        replayed = self.folder / f"{world.name}_replay"
        self.zonecast("replay", world, "--path", path, "--cap", "64MiB", "--size", "{}x{}".format(*SIZE), "--reflections",
                      "none", "--debug-views", "depth", "-o", replayed)
        ours = [support.read_png(file) for file in sorted((replayed / "depth").iterdir())]
        for viewer in VIEWERS:
            out = self.folder / f"{world.name}_{viewer}"
            done = node.script("view.mjs", address or world, path, "{}x{}".format(*SIZE), "#{:02x}{:02x}{:02x}".format(*BACKGROUND),
                               viewer, out)
            self.assertEqual(done.returncode, 0, done.stderr)
            print(world.name, viewer, json.loads(done.stdout))
            theirs = [support.read_png(file) for file in sorted(out.iterdir())]
            for i, (depth, shown) in enumerate(zip(ours, theirs, strict=True)):
                with self.subTest(world=world.name, viewer=viewer, camera=i):
                    self.assert_overlap(f"{world.name}_{viewer}_{i}", depth, shown)

    def assert_overlap(self, name, depth, shown):
        self.assertEqual((depth[:2], shown[:2]), (SIZE, SIZE))
        pixels = list(zip(silhouette(depth, (0, 0, 0)), silhouette(shown, BACKGROUND)))
        both, either = sum(a and b for a, b in pixels), sum(a or b for a, b in pixels)
        self.assertTrue(0 < sum(a for a, _ in pixels) < len(pixels), "the replay shows no silhouette")
        print(f"{name}: {both} of {either} pixels, {both / either:.5f}")
        if both / either < MIN_OVERLAP:
            KEPT.mkdir(parents=True, exist_ok=True)
            colors = {(False, False): b"\0\0\0", (True, True): b"\xff\xff\xff", (True, False): b"\0\0\xff",
                      (False, True): b"\xff\0\0"}
            pictures = {"depth": depth[2], "shown": shown[2], "map": b"".join(colors[pixel] for pixel in pixels)}
            for kind, rgb in pictures.items():
                support.write_png(KEPT / f"{name}_{kind}.png", *SIZE, rgb)
            self.fail(f"{name}: {both / either:.5f} of the silhouettes overlap; pictures in {KEPT}")

    def choose(self, drive, samples):
        """A path of some samples of another one."""
        header, *rows = drive.read_text().splitlines()
        path = self.folder / f"{drive.parent.name}.csv"
        path.write_text("\n".join([header, *(rows[i] for i in samples)]) + "\n")
        return path

    def test_a_generated_city(self):
        city = self.folder / "city"
        self.zonecast("generate", "--size-km", "0.3", "-o", city)
        self.assert_alike(self.bake("generated", city / "city.glb"), self.choose(city / "drive.csv", (100, 1700)))

    def test_a_city_far_from_the_origin(self):
        support.write_small_city(self.folder / "far.city.json")
        path = self.folder / "far.csv"
        center = (650150, 5400150, 303)
        support.write_path(path, [(0, (649930, 5399900, 360), center), (1, (650029, 5400029, 302), center)])
        world = self.bake("far", self.folder / "far.city.json", "--leaf-triangles", "100")
        self.assert_alike(world, path)
        with self.serve(world) as address:  # of another origin than the page
            self.assert_alike(world, path, address)

    @unittest.skipUnless(INGOLSTADT.is_dir(), f"{INGOLSTADT} is not there (set ZONECAST_DATA)")
    def test_a_real_city(self):
        world = self.bake("ingolstadt", INGOLSTADT / "ingolstadt.city.json")
        self.assert_alike(world, self.choose(INGOLSTADT / "drive.csv", (10, 900)))

    def test_silhouettes_that_differ_fail_and_are_kept(self):
        depth = bytes(3 * SIZE[0] * SIZE[1] // 2) + b"\x7f\x7f\x7f" * (SIZE[0] * SIZE[1] // 2)
        shown = bytes(BACKGROUND) * (SIZE[0] * SIZE[1] * 52 // 100) + b"\0\0\0" * (SIZE[0] * SIZE[1] * 48 // 100)
        with self.assertRaisesRegex(AssertionError, "0.96"):
            self.assert_overlap("differ", (*SIZE, depth), (*SIZE, shown))
        for kind in ("depth", "shown", "map"):
            self.assertEqual(support.read_png(KEPT / f"differ_{kind}.png")[:2], SIZE)
            (KEPT / f"differ_{kind}.png").unlink()


if __name__ == "__main__":
    support.main()
