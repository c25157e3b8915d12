# SPDX-License-Identifier: Apache-2.0
"""The main job on a generated city: generate, bake, inspect, replay with pictures."""
import csv
import json
import shutil

import support

FRAMES = 6
SIZE = (320, 180)
DEBUG_VIEWS = ("provenance", "bvh", "normals", "depth")
# Path samples spread over the drive: the first street, the underpass, corners.
STEP = "0:600:100"
# Largest difference of a frame from full-detail reflections, of 255. Measured: 9 with screen-space hits, whose
# silhouettes lie on other pixels; 2.3 with proxies alone; no reflections at all: 32.
MAX_RMSE_SSR_PROXY = 12.0
MAX_RMSE_PROXY = 4.0
MAX_FLIP = 0.08

SUMMARY_KEYS = """frames cap_bytes peak_ledger_bytes frames_over_cap peak_rss_bytes baseline_rss_bytes zones_loaded
    zones_evicted reloads reloads_optimal wanted_level_fraction request_to_resident_ms.p50 request_to_resident_ms.p95
    request_to_resident_ms.p99 request_to_resident_ms.max requests.issued requests.completed requests.cancelled
    requests.failed requests.retried bytes_read rays.total rays.screen rays.proxy rays.proxy_coarse rays.sky rays.lost
    pass_ms.gbuffer pass_ms.hiz pass_ms.classify pass_ms.ssr pass_ms.compact pass_ms.trace pass_ms.shade pass_ms.filter
    pass_ms.composite pass_ms.total left_out event_log_xxh3 device driver version""".split()
INSPECT_KEYS = """zones nodes source_triangles decoded_bytes smallest_cap_bytes levels disk_bytes.glb disk_bytes.zbvh
    disk_bytes.index bake_s.total bake_s.import bake_s.repair bake_s.cut bake_s.simplify bake_s.light bake_s.encode
    bake_s.bvh""".split()
LEVEL_KEYS = """triangles bytes.nodes bytes.triangles bytes.normals bytes.uv bytes.texture bytes.index
    bytes_per_triangle error_m_max error_m_mean""".split()


def look_up(document, dotted):
    for key in dotted.split("."):
        document = document[key]
    return document


class MainJob(support.Case):
    @classmethod
    def prepare(cls):
        cls.city, cls.world = cls.folder / "city", cls.folder / "world"
        cls.zonecast("generate", "--size-km", "0.3", "-o", cls.city)
        cls.zonecast("bake", cls.city / "city.glb", "-o", cls.world)
        cls.replay("shown", "--validate", "--debug-views", ",".join(DEBUG_VIEWS))

    @classmethod
    def replay(cls, name, *more):
        cls.zonecast("replay", cls.world, "--path", cls.city / "drive.csv", "--cap", "16MiB", "--frames", STEP,
                     "--size", f"{SIZE[0]}x{SIZE[1]}", "-o", cls.folder / name, *more)

    def pictures(self, name, view="frames"):
        return [support.read_png(path) for path in sorted((self.folder / name / view).glob("*.png"))]

    def test_compare_measures_proxies_against_the_detail(self):
        out = self.folder / "compared"
        self.zonecast("compare", self.world, "--path", self.city / "drive.csv", "--frames", "0:600:300",
                      "--tolerance", "0.002,0.05", "--size", f"{SIZE[0]}x{SIZE[1]}", "-o", out)
        report = json.loads((out / "compare.json").read_text())
        levels = {level["name"]: level for level in report["levels"]}
        stored = [level for level in report["levels"] if "depth" in level]
        depths = [level["depth"] for level in json.loads(self.zonecast("inspect", self.world, "--json"))["levels"]
                  if not level["detail"]]
        self.assertEqual([level["depth"] for level in stored], sorted(depths, reverse=True))
        self.assertEqual(list(levels), ["finest", *(f"level_{depth}" for depth in reversed(depths[:-1])),
                                        "tolerance_0.002", "tolerance_0.05"])
        self.assertLess(levels["finest"]["mean_flip"], MAX_FLIP)
        for finer, coarser in zip(stored, stored[1:]):
            self.assertLessEqual(finer["error_m_max"], coarser["error_m_max"])
            self.assertGreater(finer["triangles_per_frame"], coarser["triangles_per_frame"])
        for coarse in ("level_0", "tolerance_0.05"):
            self.assertGreater(levels[coarse]["mean_flip"], levels["finest"]["mean_flip"])
            self.assertLess(levels[coarse]["triangles_per_frame"], levels["finest"]["triangles_per_frame"])
        self.assertTrue(all(level["complete"] for level in levels.values()))
        width, height, _ = support.read_png(out / "contact_sheet.png")
        self.assertGreater(width, (1 + len(levels)) * SIZE[0])
        self.assertGreater(height, 4 * SIZE[1])
        for level in levels:
            self.assertEqual(len(list((out / level).glob("*.png"))), 2)
            self.assertEqual(len(list((out / f"{level}_flip").glob("*.png"))), 2)

    def test_compare_needs_nothing_but_a_world(self):
        """Eight frames of a flight over it; pictures of an earlier run go, and nothing else does."""
        out = self.folder / "toured"
        for name in ("source", "level_7"):
            (out / name).mkdir(parents=True)
            support.write_png(out / name / "000000.png", 1, 1, b"abc")
        done = self.run_zonecast("compare", self.world, "--size", "64x36", "-o", out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("8 frames", done.stdout)
        self.zonecast("compare", self.world, "--size", "64x36", "--tolerance", "0.1", "--frames", "0:2", "-o", out)
        self.assertEqual(json.loads((out / "compare.json").read_text())["frames"], ["000000", "000001"])
        self.assertEqual(sorted(path.name for path in (out / "finest").iterdir()), ["000000.png", "000001.png"])
        self.assertFalse((out / "tolerance_0.002").exists())
        done = self.run_zonecast("compare", self.world, "--size", "64x36", "--budget", "1500KiB", "--frames", "0:1",
                                 "-o", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("--budget is too small for all of the full detail", done.stderr)
        report = json.loads((out / "compare.json").read_text())
        self.assertFalse(report["source_complete"])
        self.assertTrue([level["complete"] for level in report["levels"] if level["name"] == "level_0"][0])
        self.assertTrue((out / "level_7" / "000000.png").exists(), "another program's picture was removed")

    def test_a_path_that_misses_the_world_is_told_of(self):
        path = self.folder / "astray.csv"
        support.write_path(path, [(i, (90000, 450000 + i, 2), (90010, 450000, 2)) for i in range(3)])
        out = self.folder / "astray"
        self.assert_refused(["compare", self.world, "--path", path, "-o", out], 2, "no camera of the path looks at",
                            "the first is at 90000.0, 450000.0, 2.0", "the world at x ")
        done = self.run_zonecast("replay", self.world, "--path", path, "--cap", "16MiB", "--no-render")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn("no camera of the path looks at the world", done.stderr)
        some = self.folder / "some.csv"
        lines = path.read_text().splitlines() + (self.city / "drive.csv").read_text().splitlines()[1:2]
        lines[-1] = "9," + lines[-1].split(",", 1)[1]
        some.write_text("\n".join(lines))
        done = self.run_zonecast("compare", self.world, "--path", some, "--size", "64x36", "-o", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("3 of 4 frames do not look at the world", done.stderr)

    def test_replay_needs_no_path_and_removes_its_earlier_pictures(self):
        out = self.folder / "flown"
        (out / "frames").mkdir(parents=True)
        support.write_png(out / "frames" / "mine.png", 1, 1, b"abc")
        for frames, more in (("0:600:200", ["--debug-views", "depth", "--contact-sheet"]), ("0:600:300", [])):
            self.zonecast("replay", self.world, "--cap", "16MiB", "--size", "64x36", "--frames", frames, "-o", out,
                          *more)
        self.assertEqual(sorted(path.name for path in (out / "frames").iterdir()),
                         ["000000.png", "000300.png", "mine.png"])
        self.assertEqual(sorted(path.name for path in out.iterdir()), ["frames", "frames.csv", "stats.json"])

    def test_inspect_says_where_the_world_lies(self):
        report = json.loads(self.zonecast("inspect", self.world, "--json"))
        low, high = report["bounds_m"]["min"], report["bounds_m"]["max"]
        with (self.city / "drive.csv").open() as file:
            for row in csv.DictReader(file):
                for axis, name in enumerate("xyz"):
                    self.assertTrue(low[axis] - 5 < float(row[f"eye_{name}"]) < high[axis] + 5)
        shown = self.zonecast("inspect", self.world)
        self.assertIn(f"bounds: x {low[0]:.1f} to {high[0]:.1f}, y {low[1]:.1f} to {high[1]:.1f}, ", shown)
        self.assertIn("CRS: none was named\n", shown)
        self.bake_small_city(self.folder / "small")
        self.assertIn("/EPSG/0/25832\"\n", self.zonecast("inspect", self.folder / "small"))

    def test_inspect_tells_everything_that_scripts_rely_on(self):
        text = self.zonecast("inspect", self.world, "--json", "--verify")
        report = json.loads(text)
        for key in INSPECT_KEYS:
            look_up(report, key)
        self.assertGreater(len(report["levels"]), 2)
        for level in report["levels"]:
            for key in LEVEL_KEYS:
                look_up(level, key)
        self.assertEqual(report["verified"], {"nodes": report["nodes"], "failures": 0})
        on_disk = sum(path.stat().st_size for path in self.world.rglob("*.glb"))
        self.assertEqual(report["disk_bytes"]["glb"], on_disk)
        shown = self.zonecast("inspect", self.world)
        self.assertIn("zones", shown)
        self.assertIn("thesis 4.1", shown)
        resident = report["resident_bytes_per_triangle"]
        self.assertAlmostEqual(sum(resident.values()), 2 * resident["total"], places=6)
        proxies = [level for level in report["levels"] if not level["detail"]]
        triangles = sum(level["triangles"] for level in proxies)
        self.assertAlmostEqual(resident["total"] * triangles, report["decoded_bytes"], delta=1)

    def test_inspect_tells_what_a_proxy_triangle_takes_on_the_disk(self):
        report = json.loads(self.zonecast("inspect", self.world, "--json"))
        disk = report["disk_bytes_per_triangle"]
        self.assertAlmostEqual(sum(disk.values()), 2 * disk["total"], places=6)
        proxies = [level for level in report["levels"] if not level["detail"]]
        triangles = sum(level["triangles"] for level in proxies)
        index = sum(level["bytes"]["index"] for level in proxies)
        files = [path for kind in ("glb", "zbvh") for path in self.world.glob(f"zones/*/*.{kind}")]
        sizes = [path.stat().st_size for path in files if ".detail." not in path.name]
        self.assertAlmostEqual(disk["total"] * triangles, sum(sizes) + index, delta=1)
        self.assertGreater(disk["mesh"], disk["json"])
        self.assertLess(disk["total"], 12)
        for other in ("{}", '{"disk_bytes": [1]}', '{"disk_bytes": {"proxies": {"mesh": "much"}}}'):
            copy = self.folder / "copy"
            shutil.copytree(self.world, copy)
            (copy / "bake.json").write_text(other)
            told = json.loads(self.zonecast("inspect", copy, "--json"))["disk_bytes_per_triangle"]
            self.assertEqual(list(told), ["glb", "zbvh", "index", "total"])
            self.assertAlmostEqual(told["total"], disk["total"], places=6)
            shutil.rmtree(copy)

    def test_what_a_bake_left_out_is_told_with_what_it_saves(self):
        kept = json.loads((self.world / "bake.json").read_text())["left_out"]
        self.assertEqual(json.loads(self.zonecast("inspect", self.world, "--json"))["left_out"], kept)
        counts = {entry["what"]: entry["count"] for entry in kept}
        self.assertGreater(counts["triangles without normals of their own"], 1000)
        for entry in kept:
            self.assertGreater(entry["count"], 0)
            self.assertGreater(entry["page_bytes"], 0)
        shown = self.zonecast("inspect", self.world)
        self.assertEqual(shown.count("left out: "), len(kept))
        good = {"what": "\x1b[31mlevels", "count": 3, "page_bytes": 2048}
        for other in ("[]", '"much"', '[1, {"what": 2}, {"what": "x", "count": -1, "page_bytes": 1}]'):
            copy = self.folder / "copy"
            shutil.copytree(self.world, copy)
            entries = json.loads(other)
            entries = entries + [good] if isinstance(entries, list) else entries
            (copy / "bake.json").write_text(json.dumps({"left_out": entries}))
            told = json.loads(self.zonecast("inspect", copy, "--json"))["left_out"]
            self.assertEqual(told, [good] if isinstance(entries, list) else [])
            self.assertNotIn("\x1b", self.zonecast("inspect", copy))
            shutil.rmtree(copy)

    def test_a_sealed_room_is_left_out_on_request(self):
        def box(low, high):
            at = [[(high if i >> axis & 1 else low)[axis] for axis in range(3)] for i in range(8)]
            quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
            return [[[at[i] for i in quad]] for quad in quads]

        city = {"type": "CityJSON", "version": "2.0", "transform": {"scale": [1, 1, 1], "translate": [0, 0, 0]},
                "CityObjects": {}, "vertices": []}
        for name, faces in (("house", box((0, 0, 0), (20, 20, 10))), ("hidden", box((5, 5, 2), (8, 8, 4)))):
            boundaries = []
            for ((*corners,),) in faces:
                first = len(city["vertices"])
                city["vertices"] += corners
                boundaries.append([[first, first + 1, first + 2, first + 3]])
            city["CityObjects"][name] = {"type": "Building", "geometry": [
                {"type": "MultiSurface", "lod": "2", "boundaries": boundaries}]}
        source, world = self.folder / "sealed.city.json", self.folder / "sealed"
        source.write_text(json.dumps(city))
        self.zonecast("bake", source, "-o", world, "--exterior")
        left = json.loads((world / "bake.json").read_text())["left_out"][0]
        self.assertEqual((left["what"], left["count"]), ("faces that can be seen from nowhere outside", 12))
        self.zonecast("bake", source, "-o", world)
        left = json.loads((world / "bake.json").read_text())["left_out"][0]
        self.assertNotEqual(left["what"], "faces that can be seen from nowhere outside")

    def test_inspect_holds_a_world_against_the_thesis(self):
        """Its table 4.1, as published, and the leaf proxies of ours."""
        report = json.loads(self.zonecast("inspect", self.world, "--json"))
        thesis, ours = report["table_4_1"]["thesis"], report["table_4_1"]["world"]
        self.assertEqual(thesis["zone_bytes"]["total"], 1_091_962)
        self.assertAlmostEqual(thesis["bytes_per_triangle"], 81, delta=1)
        self.assertEqual(ours["zones"], report["zones"])
        detail = [level["triangles"] for level in report["levels"] if level["detail"]]
        self.assertLessEqual(ours["triangles"], detail[0])
        self.assertLess(ours["bytes_per_triangle"], thesis["bytes_per_triangle"] / 3)
        parts = [value for part, value in ours["zone_bytes"].items() if part != "total"]
        self.assertAlmostEqual(sum(parts), ours["zone_bytes"]["total"], delta=len(parts))
        self.assertEqual(ours["bvh_build_s"], report["bake_s"]["bvh"])
        for other in ("{}", '{"bake_s": [1]}', "no JSON"):
            copy = self.folder / "copy"
            shutil.copytree(self.world, copy)
            (copy / "bake.json").write_text(other)
            report = json.loads(self.zonecast("inspect", copy, "--json"))
            self.assertNotIn("bake_s", report)
            self.assertIsNone(report["table_4_1"]["world"]["bvh_build_s"])
            shutil.rmtree(copy)

    def test_tileset_names_every_zone_file(self):
        tileset = json.loads((self.world / "tileset.json").read_text())
        self.assertEqual(tileset["asset"]["version"], "1.1")
        names = set()

        def visit(tile):
            names.add(tile["content"]["uri"])
            for child in tile.get("children", ()):
                self.assertLessEqual(child["geometricError"], tile["geometricError"])
                visit(child)

        visit(tileset["root"])
        self.assertEqual(names, {p.relative_to(self.world).as_posix() for p in self.world.rglob("*.glb")})

    def test_statistics_keep_their_promises(self):
        stats = support.read_stats(self.folder / "shown")
        for key in SUMMARY_KEYS:
            look_up(stats, key)
        self.assertEqual(stats["frames"], FRAMES)
        self.assertEqual(stats["rendered_frames"], FRAMES)
        self.assertEqual(stats["cap_bytes"], 16 << 20)
        self.assertEqual(stats["validation_messages"], 0)
        rays = stats["rays"]
        self.assertEqual(rays["lost"], 0)
        self.assertGreater(rays["total"], 0)
        for source in ("screen", "proxy", "sky"):
            self.assertGreater(rays[source], 0, source)
        self.assertEqual(rays["total"], sum(count for source, count in rays.items() if source != "total"))
        requests = stats["requests"]
        self.assertEqual(requests["issued"], requests["completed"] + requests["cancelled"] + requests["failed"])
        self.assertGreater(stats["pass_ms"]["total"], 0)

    def test_frames_csv_has_a_row_a_frame_that_adds_up(self):
        with (self.folder / "shown" / "frames.csv").open() as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([int(row["frame"]) for row in rows], list(range(0, 600, 100)))
        stats = support.read_stats(self.folder / "shown")
        for source in ("total", "screen", "proxy", "proxy_coarse", "sky", "lost"):
            self.assertEqual(sum(int(row[f"rays_{source}"]) for row in rows), stats["rays"][source], source)
        self.assertLessEqual(max(int(row["ledger_bytes"]) for row in rows), stats["peak_ledger_bytes"])

    def test_the_process_stays_within_a_cap_that_zones_come_and_go_under(self):
        """From one end of the drive to the other and back, again and again: a page that is not freed adds up."""
        with (self.city / "drive.csv").open() as file:
            rows = list(csv.DictReader(file))
        there = [[float(row[f"{point}_{axis}"]) for axis in "xyz"] for row in (rows[0], rows[300])
                 for point in ("eye", "target")]
        path, out = self.folder / "to_and_fro.csv", self.folder / "tight"
        support.write_path(path, [(f / 30, *(there[:2] if f // 4 % 2 == 0 else there[2:])) for f in range(400)])
        evicted = 0
        for cap in ("1MiB", "1536KiB", "2MiB", "3MiB"):
            for threads in (1, 4):
                self.zonecast("replay", self.world, "--path", path, "--no-render", "--cap", cap, "--threads", threads,
                              "-o", out)
                stats = support.read_stats(out)
                evicted += stats["zones_evicted"]
                self.assert_memory_within_cap(stats)
        self.assertGreater(evicted, 400, "no cap is tight")

    def test_every_view_is_a_picture_of_the_asked_size(self):
        for view in ("frames", *DEBUG_VIEWS):
            pictures = self.pictures("shown", view)
            self.assertEqual(len(pictures), FRAMES, view)
            for picture in pictures:
                self.assertEqual(picture[:2], SIZE, view)
                self.assertGreater(len(support.colors(picture)), 3, view)

    def test_reflections_come_close_to_full_detail_and_are_missed_when_off(self):
        full = self.full_detail()
        errors = {"ssr+proxy": self.pictures("shown")}
        for method in ("proxy", "none"):
            self.replay(method, "--reflections", method)
            errors[method] = self.pictures(method)
        for method, pictures in errors.items():
            errors[method] = [support.rmse(a, b) for a, b in zip(pictures, full, strict=True)]
            print(f"{method} against full detail, rmse:", *(f"{v:.2f}" for v in errors[method]))
        self.assertLess(max(errors["ssr+proxy"]), MAX_RMSE_SSR_PROXY)
        self.assertLess(max(errors["proxy"]), MAX_RMSE_PROXY)
        self.assertGreater(min(errors["none"]), 2 * MAX_RMSE_SSR_PROXY)

    def full_detail(self):
        self.replay("full", "--reflections", "full")
        stats = support.read_stats(self.folder / "full")
        self.assertEqual((stats["rays"]["screen"], stats["rays"]["lost"]), (0, 0))
        return self.pictures("full")

    def test_the_same_command_gives_the_same_pictures(self):
        self.replay("again")  # without the validation layers and the debug views: they change nothing
        first, again = (support.snapshot(self.folder / name / "frames") for name in ("shown", "again"))
        self.assertEqual(len(first), FRAMES)
        self.assertEqual(first, again)

    def test_still_views_are_named_and_come_with_a_contact_sheet(self):
        out = self.folder / "shots"
        self.zonecast("replay", self.world, "--path", self.city / "shots.json", "--cap", "16MiB", "--size", "160x90",
                      "--contact-sheet", "-o", out)
        names = [shot["name"] for shot in json.loads((self.city / "shots.json").read_text())["shots"]]
        self.assertGreaterEqual(len(names), 6)
        self.assertEqual(sorted(path.stem for path in (out / "frames").iterdir()), sorted(names))
        width, height, _ = support.read_png(out / "contact_sheet.png")
        self.assertGreater(width, 3 * 160)
        self.assertGreater(height, 2 * 90)

    def test_help_and_version_succeed(self):
        self.assertTrue(self.zonecast("--version").startswith("zonecast "))
        for command in ("generate", "bake", "inspect", "replay"):
            self.assertIn("--help", self.zonecast(command, "--help"))
            self.assertIn(command, self.zonecast("--help"))


if __name__ == "__main__":
    support.main()
