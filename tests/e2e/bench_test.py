# SPDX-License-Identifier: Apache-2.0
"""`zonecast bench trace`: every engine that runs here hits the same triangles as double precision does."""

import array
import json
import math
import random
import unittest

import support

ARGUMENTS = 2
FAILURE = 1
SIZE = "160x90"
OURS = {"zonecast/packets", "zonecast/packets_32", "zonecast/packets_storage", "zonecast/packets_w32",
        "zonecast/packets_w128", "zonecast/single", "zonecast/single_storage", "zonecast/single_shared",
        "zonecast/plain_packets", "zonecast/plain_single"}
PEERS = {"thesis", "bvh2", "ray_query", "embree", "embree_robust"}
OWN_BUILDERS = {"zonecast/" + name for name in ("auto", "binned", "sweep", "sbvh", "binned+reinsert", "sweep+reinsert",
                                                "sbvh+reinsert")}
PEER_BUILDERS = {"embree/" + name + form for name in ("morton", "sah", "sbvh") for form in ("", "+collapse")}
NEED_NO_MORE_THAN_VULKAN = OURS | {"thesis", "bvh2"}


def write_floats(path, values):
    path.write_bytes(array.array("f", values).tobytes())
    return path


def quad(a, b, c, d):
    return [*a, *b, *c, *a, *c, *d]


def block_city():
    """A floor and gabled blocks on it, not aligned to the axes: nine floats a triangle."""
    chance = random.Random(5)
    triangles = quad((-90, -90, 0), (90, -90, 0), (90, 90, 0), (-90, 90, 0))
    for i in range(64):
        x, y = 20 * (i % 8) - 70, 20 * (i // 8) - 70
        angle, height = chance.uniform(0, math.pi), chance.uniform(4, 18)
        c, s = 5 * math.cos(angle), 5 * math.sin(angle)
        low = [(x + c, y + s), (x - s, y + c), (x - c, y - s), (x + s, y - c)]
        top = (x, y, height + 3)
        for (ax, ay), (bx, by) in zip(low, low[1:] + low[:1]):
            a, b, d, e = (ax, ay, 0), (bx, by, 0), (bx, by, height), (ax, ay, height)
            triangles += quad(a, b, d, e) + [*e, *d, *top]
    return triangles


class Bench(support.Case):
    @classmethod
    def prepare(cls):
        cls.triangles = write_floats(cls.folder / "blocks.tris", block_city())
        cls.path = cls.folder / "path.csv"
        support.write_path(cls.path, [(0, (-78, -61, 2), (0, -55, 3)), (1, (-5, -60, 30), (20, 40, 0))])
        support.write_small_city(cls.folder / "city.json", blocks=3)
        support.small_drive(cls.folder / "drive.csv", blocks=3)
        cls.world = cls.folder / "world"
        cls.zonecast("bake", cls.folder / "city.json", "-o", cls.world)

    def trace(self, *arguments):
        """The report of a run, with no engine in it that says anything wrong."""
        report = json.loads(self.zonecast("bench", "trace", "--repeat", 2, "--json", "-", *arguments))
        self.assertGreater(report["rays"], 0)
        self.assertGreater(report["triangles"], 0)
        for row in report["rows"]:
            with self.subTest(engine=row["engine"]):
                self.assertEqual(row["mismatches"], 0)
                self.assertEqual(row["same"] + row["tied"] + row["missed_by_both"], report["rays"])
                self.assertGreater(row["same"], report["rays"] / 10)
                self.assertLessEqual(row["tied"], max(4, report["rays"] / 100))
                for key in ("mrays_per_s", "build_ms", "bytes_per_triangle"):
                    self.assertGreater(row[key], 0, key)
        return report

    def test_every_engine_agrees_with_double_precision_on_raw_triangles(self):
        report = self.trace("--triangles", self.triangles, "--path", self.path, "--size", SIZE)
        engines = {row["engine"] for row in report["rows"]}
        missing = {cause.split(":")[0] for cause in report["left_out"]}
        print("engines:", *sorted(engines), "; left out:", *report["left_out"])
        self.assertEqual(engines & missing, set())
        self.assertLessEqual(PEERS, engines | missing)
        self.assertLessEqual(NEED_NO_MORE_THAN_VULKAN, engines)
        self.assertEqual({row["case"] for row in report["rows"]}, {"blocks"})
        self.assertTrue(report["device"] and report["driver"])

    def test_every_engine_agrees_with_double_precision_on_whether_anything_is_hit(self):
        scene = ("--triangles", self.triangles, "--path", self.path, "--size", SIZE)
        report = self.trace(*scene, "--any-hit")
        self.assertTrue(report["any_hit"])
        self.assertLessEqual(NEED_NO_MORE_THAN_VULKAN, {row["engine"] for row in report["rows"]})
        closest = self.trace(*scene, "--engines", "bvh2")
        self.assertFalse(closest["any_hit"])
        hit = {row["same"] + row["tied"] for row in report["rows"] + closest["rows"]}
        self.assertLessEqual(max(hit) - min(hit), 4)  # ties at silhouettes
        self.assertIn("any hit", self.zonecast("bench", "trace", *scene, "--any-hit", "--engines", "bvh2", "--repeat", 1))

    def test_compression_changes_nothing_but_bytes(self):
        report = self.trace(self.world, "--path", self.folder / "drive.csv", "--size", SIZE, "--engines",
                            "zonecast/packets,zonecast/plain_packets,zonecast/single,zonecast/plain_single")
        rows = {row["engine"]: row for row in report["rows"]}
        self.assertEqual({(row["same"], row["tied"]) for row in rows.values()},
                         {(report["rows"][0]["same"], report["rows"][0]["tied"])})
        for kind in ("packets", "single"):
            self.assertGreater(rows["zonecast/plain_" + kind]["bytes_per_triangle"],
                               3 * rows["zonecast/" + kind]["bytes_per_triangle"])

    def test_dumped_rays_and_triangles_run_again(self):
        dumps = self.folder / "again.rays", self.folder / "again.tris"
        first = self.trace("--triangles", self.triangles, "--path", self.path, "--frame", 1, "--size", SIZE,
                           "--order", "tiles", "--dump-rays", dumps[0], "--dump-triangles", dumps[1])
        self.assertEqual(dumps[0].stat().st_size, 24 * first["rays"])
        self.assertEqual(dumps[1].stat().st_size, 36 * first["triangles"])
        again = self.trace("--rays", dumps[0], "--triangles", dumps[1])
        self.assertEqual(again["rays"], first["rays"])

    def test_a_world_is_traced_the_same_wherever_it_lies(self):
        dumps = []
        for offset in ("0", "1e6", "1e7"):
            dump = self.folder / f"{offset}.tris"
            self.trace(self.world, "--path", self.folder / "drive.csv", "--frame", 5, "--size", SIZE,
                       "--world-offset", offset, "--dump-triangles", dump)
            dumps.append(dump.read_bytes())
        self.assertEqual(dumps, [dumps[0]] * 3)

    def test_rays_far_from_zero_and_along_axes(self):
        far = [v + (6_400_000 if i % 3 == 0 else 0) for i, v in enumerate(block_city())]
        rays = []
        for x in range(-60, 60, 7):
            rays += [6_400_000 + x, 3, 50, 0, 0, -2] + [6_400_000 + x, -80, 2.5, -0.0, 1, 0]
        report = self.trace("--triangles", write_floats(self.folder / "far.tris", far),
                            "--rays", write_floats(self.folder / "far.rays", rays))
        self.assertEqual(report["rays"], len(rays) // 6)

    def test_values_that_are_no_numbers_are_dropped_and_counted(self):
        bad = [[math.nan] * 9, [math.inf] + [0] * 8, [3e18] + [0] * 8]
        triangles = write_floats(self.folder / "bad.tris", block_city() + sum(bad, []))
        rays = write_floats(self.folder / "bad.rays", [0, 0, 50, 0, 0, -1, math.nan, 0, 0, 0, 0, 1])
        done = self.run_zonecast("bench", "trace", "--triangles", triangles, "--rays", rays, "--engines", "bvh2",
                                 "--repeat", 1, "--json", "-")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("3 triangles", done.stderr)
        self.assertIn("1 rays", done.stderr)
        report = json.loads(done.stdout)
        self.assertEqual((report["rays"], report["rows"][0]["mismatches"]), (1, 0))

    def test_without_a_scene_the_generated_city_is_traced(self):
        report = self.trace("--size", "64x36", "--engines", "bvh2,thesis", "--frame", 4)
        self.assertEqual([row["engine"] for row in report["rows"]], ["bvh2", "thesis"])
        self.assertGreater(report["triangles"], 50_000)

    def test_the_table_has_a_line_an_engine(self):
        table = self.zonecast("bench", "trace", "--triangles", self.triangles, "--path", self.path, "--size", SIZE,
                              "--engines", "thesis,bvh2", "--repeat", 1).splitlines()
        self.assertEqual(len(table), 4)
        self.assertIn("mismatches", table[1])
        self.assertEqual([line.split()[1] for line in table[2:]], ["thesis", "bvh2"])

    def test_the_top_level_is_timed_over_any_number_of_zones(self):
        for zones in (1, 40):
            report = json.loads(self.zonecast("bench", "top-level", self.world, "--zones", zones, "--repeat", 3,
                                              "--json", "-"))
            self.assertEqual(report["zones"], zones)
            self.assertEqual([row["engine"] for row in report["rows"]], ["top_level", "show"])
            for row in report["rows"]:
                self.assertGreater(row["build_ms"], 0)
                self.assertGreaterEqual(row["p95_ms"], row["build_ms"])
                self.assertGreaterEqual(row["nodes"], zones)
                self.assertGreaterEqual(row["cost"], 1)
        self.assert_refused(["bench", "top-level", self.folder / "none"], FAILURE, "none")
        self.assert_refused(["bench", "top-level", self.world, "--zones", "0"], ARGUMENTS)

    def test_bad_files(self):
        good = ["bench", "trace", "--engines", "bvh2", "--triangles", self.triangles]
        rays = write_floats(self.folder / "one.rays", [0, 0, 50, 0, 0, -1])
        cut = self.folder / "cut.tris"
        cut.write_bytes(self.triangles.read_bytes()[:-1])
        cases = {
            "missing rays": ([*good, "--rays", self.folder / "none.rays"], "none.rays"),
            "missing triangles": (["bench", "trace", "--rays", rays, "--triangles", self.folder / "none"], "none"),
            "cut triangles": (["bench", "trace", "--rays", rays, "--triangles", cut], "cut.tris"),
            "triangles as rays": ([*good, "--rays", write_floats(self.folder / "nine.rays", [1] * 9)], "nine.rays"),
            "no rays": ([*good, "--rays", write_floats(self.folder / "no.rays", [])], "no.rays"),
            "no direction": ([*good, "--rays", write_floats(self.folder / "zero.rays", [0, 0, 1, 0, 0, 0])], "ray 0"),
            "only NaN": (["bench", "trace", "--rays", rays, "--triangles",
                          write_floats(self.folder / "nan.tris", [math.nan] * 9)], "nan.tris"),
            "no area": (["bench", "trace", "--rays", rays, "--triangles",
                         write_floats(self.folder / "flat.tris", [0] * 9)], "flat.tris"),
            "too wide": (["bench", "trace", "--rays", rays, "--triangles",
                          write_floats(self.folder / "wide.tris", [0, 0, 0, 1e6, 0, 0, 0, 1e6, 0])], "wide.tris"),
            "beyond the lattice": (["bench", "trace", "--rays", rays, "--triangles",
                                    write_floats(self.folder / "huge.tris", [0, 0, 0, 1e17, 0, 0, 0, 1e17, 0])],
                                   "huge.tris"),
            "no world": (["bench", "trace", self.folder / "none", "--path", self.path], "none"),
            "no path": ([*good, "--path", self.folder / "none.csv"], "none.csv"),
            "another place": ([*good, "--path", self.folder / "drive.csv"], "origin"),
            "no such device": ([*good, "--rays", rays, "--device", "no such device"], "no such device"),
        }
        for cause, (arguments, part) in cases.items():
            with self.subTest(cause=cause):
                self.assert_refused(arguments, FAILURE, part)

    def test_every_builder_makes_trees_that_find_the_nearest_triangle(self):
        for scene in ([self.world], ["--triangles", self.triangles]):
            report = json.loads(self.zonecast("bench", "build", *scene, "--repeat", 2, "--json", "-"))
            rows = {row["engine"]: row for row in report["rows"]}
            self.assertLessEqual(OWN_BUILDERS, rows.keys())
            missing = {cause.split(":")[0] for cause in report["left_out"]}
            self.assertEqual(PEER_BUILDERS & rows.keys(), PEER_BUILDERS - missing)
            for row in rows.values():
                with self.subTest(engine=row["engine"]):
                    self.assertEqual(row["mismatches"], 0)
                    for key in ("build_ms", "cpu_ms", "mtri_per_s", "bytes_per_triangle", "nodes", "depth"):
                        self.assertGreater(row[key], 0, key)
                    self.assertGreaterEqual(row["references_per_triangle"], 1)
                    # A ray visits the root at least; costs above a hundred nodes are no tree's.
                    for key in ("sah_cost", "ray_cost"):
                        self.assertGreater(row[key], 1, key)
                        self.assertLess(row[key], 100, key)
            best = min(row["ray_cost"] for name, row in rows.items() if name.startswith("embree/"))
            self.assertLess(rows["zonecast/auto"]["ray_cost"], 1.1 * best)

    def test_builders_by_name(self):
        table = self.zonecast("bench", "build", "--triangles", self.triangles, "--engines", "zonecast/sbvh,zonecast/binned",
                              "--repeat", 1, "--threads", 1)
        self.assertEqual([line.split()[1] for line in table.splitlines()[2:]], ["zonecast/sbvh", "zonecast/binned"])

    def test_bad_arguments_of_build(self):
        for arguments in (["--engines", "warp"], ["--engines", ""], ["--repeat", "0"], ["--threads", "0"],
                          ["--triangles", self.triangles, "--thesis"], [self.world, "--triangles", self.triangles]):
            with self.subTest(arguments=" ".join(map(str, arguments))):
                self.assert_refused(["bench", "build", *arguments], ARGUMENTS)
        for scene, part in (([self.folder / "none"], "none"), (["--triangles", self.folder / "none.tris"], "none.tris")):
            self.assert_refused(["bench", "build", *scene], FAILURE, part)

    def test_bad_arguments(self):
        good = ["bench", "trace", "--triangles", self.triangles, "--path", self.path]
        for arguments in (
            ["bench"], ["bench", "dance"], good[:4], ["bench", "trace", self.world], [*good, "--rays", self.path],
            [*good[:2], self.world, *good[2:]], [*good, "--engines", "warp"], [*good, "--engines", ""],
            [*good, "--repeat", "0"], [*good, "--threads", "0"], [*good, "--size", "0x9"], [*good, "--frame", "2"],
            [*good, "--frame", "-1"], [*good, "--order", "spiral"], [*good, "--world-offset", "nan"],
            [*good, "--world-offset", "1e9"], [*good, "--no-such-option"],
        ):
            with self.subTest(arguments=" ".join(map(str, arguments))):
                self.assert_refused(arguments, ARGUMENTS)


if __name__ == "__main__":
    unittest.TestCase.maxDiff = None
    support.main()
