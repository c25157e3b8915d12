# SPDX-License-Identifier: Apache-2.0
"""3D Tiles as input: our own tilesets come back whole, and bad ones are refused."""

import json
import struct

import support
from web_server import WebServer

FAILURE = 1


class Tilesets(support.Case):
    @classmethod
    def prepare(cls):
        support.write_small_city(cls.folder / "city.json")
        cls.world, cls.again = cls.folder / "world", cls.folder / "again"
        cls.zonecast("bake", cls.folder / "city.json", "--leaf-triangles", "64", "-o", cls.world)
        cls.zonecast("bake", cls.world / "tileset.json", "--leaf-triangles", "64", "-o", cls.again)

    def test_a_world_baked_from_a_worlds_tileset_is_the_same_city(self):
        old, new = inspect(self, self.world), inspect(self, self.again)
        detail = [level["triangles"] for level in old["levels"] if level["detail"]]
        self.assertEqual(new["source_triangles"], sum(detail))
        self.assertEqual(new["crs"], old["crs"])
        self.assertIn("25832", new["crs"])
        self.assertEqual(bounds(self.again), bounds(self.world))
        before, after = colors(self.world), colors(self.again)
        self.assertGreater(len(before), 4)
        for one, other in ((before, after), (after, before)):
            for color in one:  # in 255ths of the zone's brightest
                self.assertLess(min(max(abs(a - b) for a, b in zip(color, o)) for o in other), 0.003, color)

    def test_a_tileset_that_lacks_a_zone_or_leads_elsewhere_is_refused(self):
        tileset = json.loads((self.world / "tileset.json").read_text())
        leaf = tileset["root"]
        while "children" in leaf:
            leaf = leaf["children"][0]
        for uri, word in (("zones/none.glb", "none.glb"), ("../city.json", "leads out"), ("http://a.org/b.glb", "http")):
            leaf["content"]["uri"] = uri
            (self.world / "bad.json").write_text(json.dumps(tileset))
            with self.subTest(uri=uri):
                self.assert_refused(["bake", self.world / "bad.json", "-o", self.folder / "new"], FAILURE, self.world,
                                    word)

    def test_an_archive_and_a_web_server_give_the_world_that_the_folder_gives(self):
        self.zonecast("pack", self.world, "-o", self.folder / "world.3tz")
        self.bake(self.folder / "world.3tz", "from_archive")
        self.assert_same_world(self.folder / "from_archive")
        server = WebServer(self.world)
        self.addCleanup(server.stop)
        failed = set()

        def once(path):
            if path in failed:
                return None
            failed.add(path)
            return 503 if path.endswith("tileset.json") else None

        server.fault = once
        self.bake(server.url("tileset.json?key=1"), "from_web")
        self.assert_same_world(self.folder / "from_web")
        asked = [path for _, path, _ in server.requests]
        self.assertEqual(asked.count("/tileset.json"), 2)  # again after the fault
        self.assertEqual(len(asked), len(set(asked)) + 1)

    def test_tiles_that_are_not_there_are_skipped_when_told_to(self):
        server = WebServer(self.world)
        self.addCleanup(server.stop)
        gone = next(iter(sorted((self.world / "zones").rglob("*.detail.*glb")))).relative_to(self.world).as_posix()
        server.fault = lambda path: 404 if path == f"/{gone}" else None
        url = server.url("tileset.json")
        self.assert_refused(["bake", url, "-o", self.folder / "new"], FAILURE, "--skip-missing", gone)
        self.bake(url, "skipped", "--skip-missing")
        report = json.loads((self.folder / "skipped" / "bake.json").read_text())
        missing = [row for row in report["left_out"] if "not there" in row["what"]]
        self.assertEqual([(row["count"], row["names"]) for row in missing], [(1, [server.url(gone)])])

    def bake(self, source, name, *more):
        return self.zonecast("bake", source, "--leaf-triangles", "64", "-o", self.folder / name, *more)

    def assert_same_world(self, world):
        files = {path.relative_to(world) for path in world.rglob("*") if path.is_file()}
        for file in sorted(files):
            if file.name not in ("bake.json", "bake.cache"):
                self.assertEqual((world / file).read_bytes(), (self.again / file).read_bytes(), file)
        self.assertGreater(len(files), 4)


def inspect(case, world):
    return json.loads(case.zonecast("inspect", world, "--json", "--verify"))


def bounds(world):
    """Of the full detail, metres in the world's CRS."""
    root = json.loads((world / "tileset.json").read_text())["root"]
    anchor = root["transform"][12:15]
    low, high = [float("inf")] * 3, [float("-inf")] * 3
    tiles = [root]
    while tiles:
        tile = tiles.pop()
        tiles += tile.get("children", [])
        if ".detail." not in tile["content"]["uri"]:
            continue
        box = tile["boundingVolume"]["box"]
        for axis in range(3):
            center, half = anchor[axis] + box[axis], box[3 + 4 * axis]
            low[axis] = min(low[axis], center - half)
            high[axis] = max(high[axis], center + half)
    return low, high


def colors(world):
    """Base colours of the world's materials that are not alike."""
    data = (world / "world.zcw").read_bytes()
    nodes, materials = struct.unpack_from("<II", data, 12)
    first = 104 + 168 * nodes
    return {struct.unpack_from("<3f", data, first + 32 * i) for i in range(materials)}


if __name__ == "__main__":
    support.main()
