# SPDX-License-Identifier: Apache-2.0
"""Paging along paths: several cameras, camera_cuts, the trace, the ledger against the process."""

import csv
import json
import re
import shutil

import support


class Paging(support.Case):
    @classmethod
    def prepare(cls):
        cls.world, cls.drive, cls.back = cls.folder / "world", cls.folder / "drive.csv", cls.folder / "back.csv"
        source = cls.folder / "city.city.json"
        support.write_small_city(source)
        cls.zonecast("bake", source, "-o", cls.world, "--leaf-triangles", "64")
        support.small_drive(cls.drive)
        lines = cls.drive.read_text().splitlines()
        times = [line.split(",", 1)[0] for line in lines[1:]]
        places = [line.split(",", 1)[1] for line in reversed(lines[1:])]
        cls.back.write_text("\n".join([lines[0], *map(",".join, zip(times, places))]) + "\n")

    def replay(self, name, *more):
        out = self.folder / name
        self.zonecast("replay", self.world, "-o", out, *more)
        return support.read_stats(out)

    def test_every_camera_gets_its_pictures_under_one_cap(self):
        common = ("--cap", "64MiB", "--frames", "0:40:20", "--size", "160x90", "--source-latency", "0s")
        self.replay("two", "--path", self.drive, "--path", self.back, "--debug-views", "depth", *common)
        stats = support.read_stats(self.folder / "two")
        self.assertEqual(stats["frames"], 2)
        self.assertEqual(stats["rendered_frames"], 4)
        self.assertEqual(stats["rays"]["lost"], 0)
        self.assertEqual(stats["rays"]["total"], sum(count for kind, count in stats["rays"].items() if kind != "total"))
        rows = (self.folder / "two" / "frames.csv").read_text().splitlines()
        self.assertEqual(len(rows), 3)
        for path, folder in ((self.drive, "."), (self.back, "camera_1")):
            self.replay("one", "--path", path, "--debug-views", "depth", *common)
            for view in ("frames", "depth"):
                for name in ("000000.png", "000020.png"):
                    alone = support.read_png(self.folder / "one" / view / name)
                    together = support.read_png(self.folder / "two" / folder / view / name)
                    if view == "depth":
                        self.assertEqual(alone, together)
                    else:  # zones are finer where the other camera is near: reflections may differ a little
                        self.assertLess(support.rmse(alone, together), 4.0)

    def test_a_report_without_a_folder_is_the_same(self):
        common = ("--path", self.drive, "--no-render", "--cap", "2MiB")
        stats = self.replay("kept", *common)
        alone = json.loads(self.zonecast("replay", self.world, *common, "--json"))
        alone = alone.get("summary", alone)
        for key in ("zones_loaded", "reloads", "reloads_optimal", "bytes_read", "bytes_read_optimal", "event_log_xxh3"):
            self.assertEqual(alone[key], stats[key], key)
        self.assertGreater(alone["bytes_read_optimal"], 0)

    def test_a_trace_has_a_track_a_worker_and_counts_what_the_ledger_does(self):
        stats = self.replay("traced", "--path", self.drive, "--no-render", "--cap", "4MiB", "--trace", "--threads", "3",
                            "--source-latency", "50ms", "--source-bandwidth", "1MB/s")
        trace = json.loads((self.folder / "traced" / "trace.json").read_text())
        events = trace["traceEvents"]
        tracks = {event["tid"]: event["args"]["name"] for event in events if event["name"] == "thread_name"}
        self.assertEqual(sorted(tracks.values()), ["frames", "worker 0", "worker 1", "worker 2"])
        spans = [event for event in events if event["ph"] == "X"]
        for span in spans:
            self.assertGreaterEqual(span["dur"], 0)
            wanted = r"worker \d" if span["name"] in ("reading", "decoding") else "frames"
            self.assertRegex(tracks[span["tid"]], wanted)
        for state in ("reading", "decoding", "uploading"):
            count = sum(span["name"] == state for span in spans)
            self.assertGreaterEqual(count, stats["requests"]["completed"] - 1, state)  # the root came before the trace
        self.assertEqual(sum(event["ph"] == "b" for event in events), sum(event["ph"] == "e" for event in events))
        counters = [event["args"] for event in events if event["name"] == "ledger"]
        with (self.folder / "traced" / "frames.csv").open() as file:
            frames = [int(row["ledger_bytes"]) for row in csv.DictReader(file)]
        self.assertEqual([sum(counter.values()) for counter in counters], frames)
        # Two spans of one worker never overlap.
        for track, name in tracks.items():
            if re.fullmatch(r"worker \d", name):
                mine = sorted((span["ts"], span["ts"] + span["dur"]) for span in spans if span["tid"] == track)
                for (_, end), (begin, _) in zip(mine, mine[1:]):
                    self.assertLessEqual(end, begin + 0.002)  # printed to the nanosecond

    def test_paths_that_jump_are_measured(self):
        path = self.folder / "jumps.csv"
        samples = []
        for i in range(120):
            x = 650000 + (20 if i // 30 % 2 == 0 else 280)
            samples.append((i / 30, (x, 5400029, 302), (x + 10, 5400028, 301.5)))
        support.write_path(path, samples)
        slow = ("--source-latency", "50ms", "--source-bandwidth", "1MB/s", "--no-render", "--cap", "16MiB", "--tolerance",
                "0.05", "--path", path)
        known = self.replay("jumps", *slow)
        self.assertEqual(known["camera_cuts"]["count"], 3)
        live = self.replay("live", *slow, "--prediction", "velocity")
        self.assertEqual(live["camera_cuts"]["count"], 3)
        self.assertEqual(live["camera_cuts"]["unfinished"], 0)
        # Whoever knows the path has loaded what a live camera comes upon.
        self.assertLess(known["camera_cuts"]["to_target_ms"]["max"], live["camera_cuts"]["to_target_ms"]["max"])
        self.assertGreater(known["wanted_level_fraction"], live["wanted_level_fraction"])
        self.assertGreater(known["prefetch"]["used_bytes"], 0)

    def test_options_that_make_no_sense_are_refused(self):
        base = ("replay", self.world, "--cap", "16MiB", "--no-render")
        self.assert_refused((*base, "--path", self.drive, "--trace"), 2, "--trace")
        self.assert_refused((*base, "--path", self.drive, "--path", self.folder / "none.csv"), 1, "none.csv")
        self.assert_refused((*base, "--path", self.drive, "--prediction", "tarot"), 2, "--prediction")
        self.assert_refused((*base, "--path", self.drive, "--upload-budget", "much"), 2, "much")
        self.assert_refused((*base, "--path", self.drive, "--upload-budget", "0.5B"), 2, "--upload-budget")

    def test_a_cap_that_is_printed_reaches_its_fraction_and_a_lower_one_does_not(self):
        def reached(cap):
            return json.loads(self.zonecast("replay", self.world, "--path", self.drive, "--no-render", "--cap", cap,
                                            "--json"))["summary"]["wanted_level_fraction"]

        report = json.loads(self.zonecast("caps", self.world, "--path", self.drive, "--fractions", "0,0.5,0.9,1", "--json"))
        self.assertEqual(report["frames"], 40)
        smallest = json.loads(self.zonecast("inspect", self.world, "--json"))["smallest_cap_bytes"]
        self.assertEqual(report["smallest_cap_bytes"], smallest)
        self.assertEqual([cap["fraction"] for cap in report["caps"]], [0, 0.5, 0.9, 1])
        self.assertEqual(report["caps"][0]["cap_bytes"], smallest)
        for cap in report["caps"]:
            self.assertGreaterEqual(cap["reached"], cap["fraction"])
            self.assertEqual(reached(cap["cap_bytes"]), cap["reached"])
        for cap in report["caps"][1:]:
            lower = cap["cap_bytes"] * 9 // 10
            self.assertLess(reached(lower) if lower >= smallest else 0, cap["fraction"], cap)
        self.assertGreater(report["caps"][-1]["cap_bytes"], smallest)
        text = self.zonecast("caps", self.world, "--path", self.drive)
        self.assertRegex(text, rf"(?m)^ *100\.0 % +100\.0 %.* {report['caps'][-1]['cap_bytes']}$")
        self.assertEqual(len(text.splitlines()), 7)

    def test_a_fraction_that_no_cap_reaches_has_none(self):
        world = self.folder / "damaged"
        shutil.copytree(self.world, world)
        for page in sorted((world / "zones").rglob("*.zbvh")):
            if page.parent.name != "0" and ".detail." not in page.name:
                page.write_bytes(b"")
        done = self.run_zonecast("caps", world, "--path", self.drive, "--fractions", "1", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        (cap,) = json.loads(done.stdout)["caps"]
        self.assertEqual((cap["cap_bytes"], cap["reached"]), (None, 0))
        self.assertIn("zones/", done.stderr)


if __name__ == "__main__":
    support.main()
