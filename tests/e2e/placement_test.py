# SPDX-License-Identifier: Apache-2.0
"""Inputs stand where --scale, --up, --offset and --crs put them."""

import json

import support

# A box of 12 x 8 x 5, as it is written in the file.
SIZE = (12, 8, 5)


def box():
    corners = ["v %d %d %d" % tuple(SIZE[axis] * (i >> axis & 1) for axis in range(3)) for i in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (3, 2, 6, 7), (1, 3, 7, 5), (2, 0, 4, 6)]
    return "\n".join(corners + ["f " + " ".join(str(corner + 1) for corner in quad) for quad in quads]) + "\n"


class Placement(support.Case):
    @classmethod
    def prepare(cls):
        cls.model = cls.folder / "box.obj"
        cls.model.write_text(box())

    def bake(self, *arguments):
        """What inspect says of the world."""
        world = self.folder / "world"
        self.zonecast("bake", *arguments, "-o", world, "--no-light")
        return json.loads(self.zonecast("inspect", world, "--json")), json.loads((world / "bake.json").read_text())

    def assert_bounds(self, report, low, high):
        for limit, expected in (("min", low), ("max", high)):
            for axis in range(3):
                self.assertAlmostEqual(report["bounds_m"][limit][axis], expected[axis], delta=0.01)

    def test_one_input(self):
        report, baked = self.bake(self.model, "--scale", "0.5", "--up", "y", "--offset", "677000,5405000,400", "--crs",
                                  "EPSG:25832")
        # Its y becomes z, and its z points south.
        self.assert_bounds(report, (677000, 5405000 - SIZE[2] / 2, 400), (677000 + SIZE[0] / 2, 5405000, 400 + SIZE[1] / 2))
        self.assertEqual(report["crs"], "EPSG:25832")
        self.assertEqual([baked["options"][name] for name in ("scale", "up", "offset", "crs")],
                         [["0.5"], ["y"], ["677000,5405000,400"], ["EPSG:25832"]])

    def test_each_input_its_own(self):
        report, _ = self.bake(self.model, self.model, "--offset", "0,0,0", "--offset", "-20,30,1")
        self.assert_bounds(report, (-20, 0, 0), (SIZE[0], 30 + SIZE[1], 1 + SIZE[2]))
        self.assertEqual(report["crs"], "")

    def test_inputs_of_two_systems_meet(self):
        # The same place in two zones of the same grid: 12 degrees east, by cs2cs of PROJ 9.1.
        report, _ = self.bake(self.model, self.model, "--crs", "EPSG:25832", "--crs", "EPSG:25833",
                              "--offset", "719721.2607,5424012.8101,400", "--offset", "280278.7393,5424012.8101,400")
        self.assertEqual(report["crs"], "EPSG:25832")
        low, high = report["bounds_m"]["min"], report["bounds_m"]["max"]
        self.assertAlmostEqual(low[2], 400, delta=0.01)
        # Zones are turned against each other by 4.5 degrees there.
        for axis in (0, 1):
            self.assertLess(high[axis] - low[axis], 14)

    def test_wrong_values_are_named(self):
        never = self.folder / "never"
        for option, value, words in (
            ("--scale", "0", "a number from 1e-9 to 1e9, not '0'"),
            ("--scale", "inch", "not 'inch'"),
            ("--up", "w", "x, y, z or auto, not 'w'"),
            ("--offset", "1,2", "three numbers"),
            ("--offset", "1,2,nan", "three numbers"),
            ("--crs", "EPSG:1", "not 'EPSG:1'"),
        ):
            with self.subTest(option=option, value=value):
                self.assert_refused(["bake", self.model, option, value, "-o", never], 2, words)
        self.assert_refused(["bake", self.model, self.model, *["--scale", "1"] * 3, "-o", never], 2, "--scale is given 3 times")
        self.assertFalse(never.exists())


if __name__ == "__main__":
    support.main()
