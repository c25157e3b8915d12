# SPDX-License-Identifier: Apache-2.0
"""3D Tiles as input: our own tilesets come back whole, and bad ones are refused."""

import json
import struct

import support

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
        self.assertGreater(len(looks(self.world)), 4)
        self.assertEqual(looks(self.again), looks(self.world))

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


def looks(world):
    """Colour and roughness of every material of the full detail, by the world's number for it, in order of colour."""
    found = {}
    for path in world.glob("zones/*/*.detail.glb"):
        data = path.read_bytes()
        document = json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]])
        for material in document["materials"]:
            pbr = material["pbrMetallicRoughness"]
            found[material["extras"]["zonecast_material"]] = (pbr["baseColorFactor"], pbr["roughnessFactor"])
    return sorted(found.values())


if __name__ == "__main__":
    support.main()
