# SPDX-License-Identifier: Apache-2.0
"""Real cities: a town under a small cap, an inner-city street with pictures, and two more models."""

import json
import unittest

import support

MIB = 1 << 20


def needs(*names):
    missing = [name for name in names if not (support.DATA / name).is_file()]
    return unittest.skipIf(missing, f"{', '.join(missing)} not in {support.DATA} (set ZONECAST_DATA)")


@needs("bayreuth.city.jsonl", "bayreuth_drive.csv")
class Bayreuth(support.Case):
    """A town of 9 × 8 km, driven through at 300 km/h."""

    FRAMES = 6907

    @classmethod
    def prepare(cls):
        cls.world = cls.folder / "world"
        cls.zonecast("bake", support.DATA / "bayreuth.city.jsonl", "-o", cls.world)

    def page(self, name, *more):
        out = self.folder / name
        self.zonecast("replay", self.world, "--path", support.DATA / "bayreuth_drive.csv", "--no-render", "-o", out,
                      *more)
        stats = support.read_stats(out)
        self.assertEqual(stats["frames"], self.FRAMES)
        self.assertEqual(stats["requests"]["failed"], 0)
        self.assert_memory_within_cap(stats)
        return stats

    def test_bakes_whole(self):
        self.zonecast("inspect", self.world, "--verify")

    def test_every_frame_stays_under_the_cap_and_pages_the_same_at_any_thread_count(self):
        # Under 2 MiB little more than the root fits; 3 MiB is where zones come and go.
        for cap, evicts in (("2MiB", False), ("3MiB", True)):
            for more in ((), ("--source-latency", "50ms", "--source-bandwidth", "20MB/s")):
                with self.subTest(cap=cap, more=more):
                    runs = [self.page("paged", "--cap", cap, "--clock", "virtual", "--threads", threads, *more)
                            for threads in (1, 2, 4)]
                    self.assertEqual(len({run["event_log_xxh3"] for run in runs}), 1)
                    if evicts:
                        self.assertGreater(runs[0]["zones_evicted"], 10)
                        self.assertLessEqual(runs[0]["reloads_optimal"], runs[0]["reloads"])

    def test_the_ledger_agrees_with_what_the_process_holds(self):
        stats = self.page("held", "--cap", "64MiB")
        self.assertEqual(stats["wanted_level_fraction"], 1)
        held = stats["peak_rss_bytes"] - stats["baseline_rss_bytes"]
        print(f"ledger {stats['peak_ledger_bytes'] / MIB:.1f} MiB, process {held / MIB:.1f} MiB above its baseline")
        self.assertLessEqual(abs(held - stats["peak_ledger_bytes"]), 0.1 * stats["peak_ledger_bytes"] + 8 * MIB)


@needs("bayreuth.city.jsonl", "bayreuth_drive.csv")
class BayreuthInSmallZones(support.Case):
    """The same town in zones that take little memory to decode, over a slow link: a folder, an archive, and over HTTP."""

    @classmethod
    def prepare(cls):
        cls.world = cls.folder / "world"
        cls.worlds = [cls.world, cls.folder / "world.3tz"]
        cls.zonecast("bake", support.DATA / "bayreuth.city.jsonl", "--leaf-triangles", "1000", "-o", cls.worlds[0])
        cls.zonecast("pack", cls.worlds[0], "-o", cls.worlds[1])
        report = json.loads(cls.zonecast("inspect", cls.worlds[0], "--json"))
        cls.decoded, cls.smallest = report["decoded_bytes"], report["smallest_cap_bytes"]
        for world in list(cls.worlds):
            server = cls.serve(world)
            cls.worlds.append(server.__enter__())
            cls.addClassCleanup(server.__exit__, None, None, None)

    def page(self, world, cap, *more):
        out = self.folder / "out"
        self.zonecast("replay", world, "--path", support.DATA / "bayreuth_drive.csv", "--no-render", "--cap", cap,
                      "--tolerance", "0.05", "--source-latency", "50ms", "--source-bandwidth", "20MB/s", "-o", out, *more)
        return support.read_stats(out)

    def test_every_cap_holds_for_ledger_and_process_and_paging_is_near_beladys(self):
        for share, level in ((1, 0.99), (2, 0.99), (4, 0.99), (8, 0), (100, 0)):
            cap = max(self.decoded // share, self.smallest)
            logs = set()
            for world in self.worlds:
                with self.subTest(share=share, world=str(world)):
                    stats = self.page(world, self.cap_for(world, cap))
                    self.assertGreaterEqual(stats["wanted_level_fraction"], level)
                    self.assertLessEqual(stats["bytes_read"], 1.15 * stats["bytes_read_optimal"])
                    self.assert_memory_within_cap(stats)
                    logs.add(stats["event_log_xxh3"])
            self.assertEqual(len(logs), 1)

    def test_pages_the_same_with_any_number_of_threads(self):
        logs = {self.page(self.worlds[0], self.decoded // 4, "--threads", n)["event_log_xxh3"] for n in (1, 2, 4, 8)}
        self.assertEqual(len(logs), 1)


@needs("ingolstadt/ingolstadt.city.json", "ingolstadt/drive.csv")
class Ingolstadt(support.Case):
    """An inner-city street with windows."""

    def test_the_street_reflects_its_houses(self):
        world, out = self.folder / "world", self.folder / "out"
        self.zonecast("bake", support.DATA / "ingolstadt/ingolstadt.city.json", "-o", world)
        self.zonecast("inspect", world, "--verify")
        self.zonecast("replay", world, "--path", support.DATA / "ingolstadt/drive.csv", "--cap", "64MiB", "--frames",
                      "0:300:100", "--size", "640x360", "--validate", "-o", out)
        stats = support.read_stats(out)
        self.assertEqual(stats["rendered_frames"], 3)
        self.assertEqual(stats["validation_messages"], 0)
        self.assertEqual(stats["rays"]["lost"], 0)
        self.assertGreater(stats["rays"]["proxy"], 1000)
        self.assertGreater(stats["rays"]["screen"], 1000)


class OtherCities(support.Case):
    def bake(self, name):
        world = self.folder / "world"
        self.zonecast("bake", support.DATA / name, "-o", world)
        self.assertIn(" 0 failures", self.zonecast("inspect", world, "--verify"))

    @needs("delft.city.json")
    def test_delft(self):
        self.bake("delft.city.json")

    @needs("rotterdam/rotterdam_subset.json")
    def test_rotterdam_with_missing_textures(self):
        self.bake("rotterdam/rotterdam_subset.json")


if __name__ == "__main__":
    support.main()
