# SPDX-License-Identifier: Apache-2.0
"""Worlds as others see them: the Khronos glTF validator, another Draco decoder, the 3D Tiles tools."""
import json
import shutil
import unittest

import node
import support

INGOLSTADT = support.DATA / "ingolstadt" / "ingolstadt.city.json"


class Validators(support.Case):
    @classmethod
    def prepare(cls):
        node.install()
        support.write_small_city(cls.folder / "small.city.json")
        cls.world = cls.folder / "small"
        cls.zonecast("bake", cls.folder / "small.city.json", "--leaf-triangles", "100", "-o", cls.world)

    def assert_valid(self, world):
        done = node.script("validate.mjs", world)
        self.assertEqual(done.returncode, 0, done.stderr)
        totals = json.loads(done.stdout)
        print(world.name, totals)
        self.assertEqual((totals["errors"], totals["warnings"]), (0, 0))
        index = json.loads(self.zonecast("inspect", world, "--json"))
        self.assertEqual((totals["glbs"], totals["tiles"]), (index["nodes"], index["nodes"]))
        self.assertEqual(totals["triangles"], sum(level["triangles"] for level in index["levels"]))

    def assert_fault(self, change, *parts):
        """One fault, which holds `parts`, is found in a copy of the world after change(its folder, a leaf's tile)."""
        broken = self.folder / "broken"
        shutil.copytree(self.world, broken)
        self.addCleanup(shutil.rmtree, broken)
        tileset = json.loads((broken / "tileset.json").read_text())
        leaf = tileset["root"]
        while "children" in leaf:
            leaf = leaf["children"][0]
        change(broken, leaf)
        (broken / "tileset.json").write_text(json.dumps(tileset))
        done = node.script("validate.mjs", broken)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertEqual(done.stderr.splitlines()[1:], ["faults: 1"], done.stderr)
        for part in (leaf["content"]["uri"], *parts):
            self.assertIn(part, done.stderr)

    def test_a_small_city_has_no_fault(self):
        self.assert_valid(self.world)

    def test_a_generated_city_has_no_fault(self):
        self.zonecast("generate", "--size-km", "0.3", "-o", self.folder / "city")
        world = self.folder / "generated"
        self.zonecast("bake", self.folder / "city" / "city.glb", "-o", world)
        self.assert_valid(world)

    @unittest.skipUnless(INGOLSTADT.is_file(), f"{INGOLSTADT} is not there (set ZONECAST_DATA)")
    def test_a_real_city_has_no_fault(self):
        world = self.folder / "ingolstadt"
        self.zonecast("bake", INGOLSTADT, "-o", world)
        self.assert_valid(world)

    def test_a_fault_in_one_mesh_is_found(self):
        def change(world, leaf):
            file = world / leaf["content"]["uri"]
            data = file.read_bytes()
            self.assertIn(b'"scene":0', data)
            file.write_bytes(data.replace(b'"scene":0', b'"scene":1'))

        self.assert_fault(change, "UNRESOLVED_REFERENCE")

    def test_geometry_outside_its_volume_is_found(self):
        def change(_, leaf):
            leaf["boundingVolume"]["box"][3] /= 2

        self.assert_fault(change, "geometry leaves its volume")

    def test_a_volume_outside_its_parents_is_found(self):
        def change(_, leaf):
            leaf["boundingVolume"]["box"][11] *= 100

        self.assert_fault(change, "volume leaves its parent's")

    def test_the_3d_tiles_tools_read_a_world_and_its_archive_whole(self):
        packed = self.folder / "packed.3tz"
        self.zonecast("pack", self.world, "-o", packed)
        files = sorted(file.relative_to(self.world) for file in self.world.rglob("*.glb"))
        for source in (self.world / "tileset.json", packed):
            unpacked = self.folder / source.stem
            done = node.run([node.PACKAGES / ".bin" / "3d-tiles-tools", "convert", "-i", source, "-o", unpacked])
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(files, sorted(file.relative_to(unpacked) for file in unpacked.rglob("*.glb")))
            for file in files:
                self.assertEqual((unpacked / file).read_bytes(), (self.world / file).read_bytes(), file)


if __name__ == "__main__":
    support.main()
