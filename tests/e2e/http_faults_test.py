# SPDX-License-Identifier: Apache-2.0
"""A server that fails in every way: no crash, no hole, every failure counted, full quality after it recovers."""
import csv
import json
import shutil
import threading
import time

import support
import web_server

FAILURE = 1
# What a page's file can meet, in a folder; what a range of an archive can meet beside.
FAULTS = ("short", "truncated", "flipped", "stall", "reset", "long", "packed", "headers", "loop", 404, 429, 500, 503)
RANGE_FAULTS = ("range", "whole", 416)


class Faults(support.Case):
    @classmethod
    def prepare(cls):
        cls.site = cls.folder / "site"
        cls.site.mkdir()
        cls.world = cls.site / "world"
        cls.bake_small_city(cls.world, cls.site / "world.3tz")
        cls.index_bytes = (cls.world / "world.zcw").stat().st_size
        # Down the street, then still: time for everything to be tried again.
        cls.path = cls.folder / "path.csv"
        cls.write_drive(cls.path, still_s=30)
        cls.expected, cls.last = cls.replay(cls.world)[::2]

    @staticmethod
    def write_drive(path, still_s, moving_s=4.0, frames_per_s=10):
        rows = []
        for i in range(int((moving_s + still_s) * frames_per_s)):
            time_s = i / frames_per_s
            x = 650000 + 300 * min(time_s / moving_s, 1)
            rows.append((time_s, (x, 5400029, 302), (x + 10, 5400028, 301.5)))
        support.write_path(path, rows)

    def setUp(self):
        self.server = web_server.WebServer(self.site)
        self.addCleanup(self.server.stop)

    @classmethod
    def replay(cls, world, *options, path=None, render=False, timeout_s=240, failing=False):
        """Summary, the source's figures and the last frame's. `failing`: pages that are wanted to the end never come."""
        out = cls.folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        drawing = ("--size", "160x90") if render else ("--no-render",)
        done = cls.run_zonecast("replay", world, "--path", path or cls.path, "--cap", cls.cap_for(world), "-o", out,
                                *drawing, *options, timeout_s=timeout_s)
        if done.returncode != (FAILURE if failing else 0):
            raise AssertionError(f"{world}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
        stats = json.loads((out / "stats.json").read_text())
        if failing:
            cls.check_last_line(world, done, stats["summary"])
        for part in ("in_flight", "decoded"):
            if stats["ledger"][part]["current_bytes"] != 0:
                raise AssertionError(f"{part} bytes are left: {stats['ledger'][part]}")
        with (out / "frames.csv").open() as rows:
            return stats["summary"], stats["source"], list(csv.DictReader(rows))[-1]

    @staticmethod
    def check_last_line(world, done, summary):
        """World, how many, the first cause, what to do; the text says the same."""
        line, count = done.stderr.splitlines()[-1], summary["failing_nodes"]
        nodes = f"{count} node" + ("" if count == 1 else "s")
        for part in (f"zonecast: {world}: {nodes} of the last frame could not be read", "the first because",
                     "--allow-failures"):
            if part not in line:
                raise AssertionError(f"{part} is not in {line}")
        for part in ("wanted level in ", f"{summary['failed_nodes']} node", f"failed, {count} of them to the end"):
            if part not in done.stdout:
                raise AssertionError(f"{part} is not in {done.stdout}")
        if not 0 < count <= summary["failed_nodes"]:
            raise AssertionError(f"{count} of {summary['failed_nodes']} failed nodes are failing")

    def assert_recovered(self, summary, last):
        counts = summary["requests"]
        self.assertEqual(counts["issued"], counts["completed"] + counts["cancelled"] + counts["failed"])
        self.assertGreater(counts["failed"], 0)
        self.assertGreater(counts["retried"], 0)
        self.assertGreater(summary["failed_nodes"], 0)
        self.assertEqual(summary["failing_nodes"], 0)
        self.assert_memory_within_cap(summary)
        for key in ("missing_nodes", "wanted_nodes", "resident_nodes"):
            self.assertEqual(last[key], self.last[key], key)
        self.assertEqual(last["missing_nodes"], "0")

    def fail_some(self, fault, times=6):
        """That fault for the first requests for pages' files, then none: where it struck. Not for the root's, which is read
        when the world is opened."""
        struck = []

        def choose(path):
            with self.server.lock:
                asked = len(self.server.requests)
                if ("/zones/" in path and "/zones/0/" not in path) or (path.endswith(".3tz") and asked > 12):
                    if len(struck) < times:
                        struck.append(path)
                        return fault
            return None

        self.server.fault = choose
        return struck

    def test_every_fault_of_a_page_is_counted_and_mended(self):
        for name, faults in (("world", FAULTS), ("world.3tz", FAULTS + RANGE_FAULTS)):
            for fault in faults:
                with self.subTest(world=name, fault=fault):
                    self.server.requests.clear()
                    # A redirection is followed four times.
                    times = 60 if fault == "loop" else 6
                    struck = self.fail_some(fault, times)
                    summary, source, last = self.replay(self.server.url(name), "--timeout", "300ms")
                    self.assertEqual(len(struck), times)
                    self.assert_recovered(summary, last)
                    # A page has two files; libcurl repeats what was reset on a connection that it had used before.
                    least = 1 if fault in ("reset", "loop") else 3
                    self.assertGreaterEqual(summary["requests"]["failed"], least)
                    self.assertLessEqual(summary["requests"]["failed"], 6 if times == 6 else 12)
                    if fault not in ("flipped", "truncated"):  # sound answers, as far as HTTP can tell
                        self.assertGreaterEqual(source["failed"], least)

    def test_what_fails_while_a_world_is_opened_is_tried_again(self):
        for name in ("world", "world.3tz"):
            for fault in ("short", "reset", "stall", 429, 503):
                with self.subTest(world=name, fault=fault):
                    struck = []

                    def choose(path, fault=fault, struck=struck):
                        if path not in struck:
                            struck.append(path)
                            return fault if "zones" not in path else None
                        return None

                    self.server.fault = choose
                    summary, source, _ = self.replay(self.server.url(name), "--timeout", "300ms")
                    self.assertEqual(summary["event_log_xxh3"], self.expected["event_log_xxh3"])
                    self.assertEqual(source["failed"], 1)

    def test_no_ray_is_lost_while_pages_fail(self):
        refuse = set()

        def choose(path):
            with self.server.lock:  # every file fails twice, of the root and the index none
                if "/zones/0/" in path or "/zones/" not in path or (path, 2) in refuse:
                    return None
                refuse.add((path, 2) if (path, 1) in refuse else (path, 1))
            return 503

        self.server.fault = choose
        path = self.folder / "short.csv"
        self.write_drive(path, still_s=2, moving_s=1, frames_per_s=8)
        summary, _, last = self.replay(self.server.url("world"), path=path, render=True)
        self.assertGreater(summary["requests"]["failed"], 10)
        self.assertGreater(summary["rays"]["proxy"] + summary["rays"]["proxy_coarse"], 0)
        self.assertEqual(summary["rays"]["lost"], 0)
        self.assertEqual(last["missing_nodes"], "0")

    def test_a_server_is_left_alone_as_long_as_it_asks(self):
        for status in (429, 503):
            self.server.retry_after = 1
            struck = self.fail_some(status, times=3)
            summary, _, last = self.replay(self.server.url("world"))
            self.assertEqual(len(struck), 3)
            self.assert_recovered(summary, last)
            self.server.retry_after = 1000  # longer than the path
            struck = self.fail_some(status, times=3)
            summary, _, _ = self.replay(self.server.url("world"))
            self.assertEqual(len(struck), 3)
            self.assertGreater(summary["requests"]["failed"], 0)
            self.assertEqual(summary["failing_nodes"], 0)  # finer pages cover their ground
            self.assertEqual(summary["requests"]["retried"], 0)

    def test_a_server_that_dies_and_comes_back(self):
        path = self.folder / "wall.csv"
        self.write_drive(path, still_s=5, moving_s=3)
        dying, dead = threading.Event(), threading.Event()

        def die():
            dying.wait(60)
            self.server.stop()
            dead.set()
            time.sleep(1)
            self.server.start()

        def choose(path):
            with self.server.lock:
                pages = sum("/zones/" in one for _, one, _ in self.server.requests)
            if pages > 20 and not dead.is_set():
                dying.set()
                dead.wait(60)  # no answer any more

        killer = threading.Thread(target=die)
        killer.start()
        self.server.fault = choose
        summary, source, last = self.replay(self.server.url("world"), "--clock", "wall", path=path)
        killer.join()
        self.assertTrue(dead.is_set())
        self.assertGreater(source["failed"], 0)
        self.assertGreater(summary["requests"]["failed"], 0)
        self.assert_recovered(summary, last)

    def test_a_world_that_changes_is_one_clear_error_and_no_mixture(self):
        """Another city in the same place, half way: pages that are not the same any more fail, and say why."""
        other = self.folder / "other"
        support.write_small_city(self.folder / "other.json")
        text = (self.folder / "other.json").read_text().replace("16000]", "19000]").replace("13000]", "12500]")
        (self.folder / "other.json").write_text(text)
        self.zonecast("bake", self.folder / "other.json", "--leaf-triangles", "64", "-o", other)
        self.zonecast("pack", other, "-o", self.folder / "other.3tz")
        for name in ("world", "world.3tz"):
            with self.subTest(name):
                place, aside = self.site / name, self.site / f"{name}.aside"
                replacement = self.folder / ("other" if name == "world" else "other.3tz")
                changed = threading.Event()

                def change(path, place=place, aside=aside, replacement=replacement, changed=changed):
                    with self.server.lock:
                        if len(self.server.requests) > 20 and not changed.is_set():
                            place.rename(aside)
                            (shutil.copytree if replacement.is_dir() else shutil.copy)(replacement, place)
                            changed.set()

                self.server.requests.clear()
                self.server.fault = change
                out = self.folder / "out"
                try:
                    done = self.run_zonecast("replay", self.server.url(name), "--path", self.path, "--cap", "8MiB",
                                             "--no-render", "-o", out)
                finally:
                    self.server.fault = lambda path: None
                    shutil.rmtree(place) if place.is_dir() else place.unlink()
                    aside.rename(place)
                self.assertTrue(changed.is_set())
                self.assertEqual(done.returncode, FAILURE, done.stderr)
                self.assertIn("changed on the server since it was opened", done.stderr.splitlines()[-1])
                self.assertNotIn("damaged", done.stderr)
                summary = support.read_stats(out)
                self.assertGreater(summary["requests"]["failed"], 0)
                self.assert_memory_within_cap(summary)

    def test_a_server_that_never_works_is_one_line(self):
        for fault in ("short", "long", "headers", "loop", "packed", "stall", 404, 503):
            with self.subTest(fault=fault):
                self.server.fault = lambda path, fault=fault: fault
                self.assert_refused(["inspect", self.server.url("world"), "--timeout", "300ms"], FAILURE,
                                    self.server.url("world/world.zcw"))

    def test_pages_that_are_all_damaged_hold_nothing_up(self):
        # Each is asked after once more, all at once: what waits begins as soon as another ends.
        for name in ("world", "world.3tz"):
            for fault in ("flipped", 404) if name == "world" else ("flipped",):
                with self.subTest(world=name, fault=fault):
                    self.server.requests.clear()
                    self.server.fault = lambda path, fault=fault: (
                        fault if ("/zones/" in path and "/zones/0/" not in path) or
                        (path.endswith(".3tz") and len(self.server.requests) > 12) else None)
                    summary, _, _ = self.replay(self.server.url(name), "--threads", 4, timeout_s=50, failing=True)
                    self.assertGreater(summary["requests"]["failed"], 20)

    def test_a_body_without_end_takes_no_memory(self):
        self.server.fault = lambda path: "long" if "/zones/" in path and "/zones/0/" not in path else None
        summary, _, _ = self.replay(self.server.url("world"), failing=True)
        self.assertGreater(summary["requests"]["failed"], 20)
        summary, _, _ = self.replay(self.server.url("world"), "--allow-failures")
        self.assertGreater(summary["failing_nodes"], 0)
        self.assertLess(summary["peak_rss_bytes"] - summary["baseline_rss_bytes"], (8 << 20) * 1.05 + (4 << 20))
        self.server.fault = lambda path: "long" if path.endswith("world.zcw") else None
        self.assert_refused(["replay", self.server.url("world"), "--path", self.path, "--cap", "24MiB", "--no-render"],
                            FAILURE, self.server.url("world/world.zcw"), f"sends more than {24 << 20} bytes")


if __name__ == "__main__":
    support.main()
