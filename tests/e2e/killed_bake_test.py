# SPDX-License-Identifier: Apache-2.0
"""A bake that is killed at any moment leaves a whole world behind, and the next one is none the worse."""

import os
import pty
import shutil
import signal
import subprocess
import time

import support

MOMENTS = 30
STAGES = {"import", "snap", "cut", "simplify", "encode", "bvh"}


class KilledBake(support.Case):
    @classmethod
    def prepare(cls):
        cls.old_city, cls.new_city = cls.folder / "old.json", cls.folder / "new.json"
        support.write_small_city(cls.old_city, blocks=12)
        support.write_small_city(cls.new_city, blocks=14)
        cls.old, cls.clean, cls.world = cls.folder / "old", cls.folder / "clean", cls.folder / "world"
        cls.zonecast(*cls.bake(cls.old_city, cls.old))
        started = time.monotonic()
        cls.zonecast(*cls.bake(cls.new_city, cls.clean))
        cls.whole_s = time.monotonic() - started
        cls.old_bytes, cls.new_bytes = content(cls.old), content(cls.clean)

    @staticmethod
    def bake(city, world):
        return ["bake", city, "--leaf-triangles", "200", "-o", world]

    def setUp(self):
        self.put_old_world()

    def put_old_world(self):
        shutil.rmtree(self.world, ignore_errors=True)
        shutil.copytree(self.old, self.world)

    def start(self, **streams):
        return subprocess.Popen([support.BINARY, *map(str, self.bake(self.new_city, self.world))], **streams)

    def kill(self, process):
        process.kill()
        process.wait()

    def check(self):
        """After a kill. Whether the new world had taken its place."""
        self.zonecast("inspect", self.world, "--verify")
        found = content(self.world)
        self.assertIn(found, (self.old_bytes, self.new_bytes))
        self.zonecast(*self.bake(self.new_city, self.world))
        self.assertEqual(content(self.world), self.new_bytes)
        self.assertFalse(self.beside.exists(), "the next bake leaves what the dead one left")
        self.put_old_world()
        return found == self.new_bytes

    @property
    def beside(self):
        return self.folder / ".world.baking"

    def test_at_moments_all_over_its_run(self):
        left = 0
        for moment in range(MOMENTS):
            with self.subTest(moment=moment):
                process = self.start()
                time.sleep(self.whole_s * moment / (MOMENTS - 1))
                self.kill(process)
                left += self.beside.exists()
                self.check()
        self.assertGreater(left, MOMENTS // 4, "hardly any was killed at work")

    def test_at_every_stage_that_it_names(self):
        stages = self.named_stages()
        self.assertGreaterEqual(stages, STAGES)
        over = 0
        for stage in sorted(stages):
            with self.subTest(stage=stage):
                with Terminal() as terminal:
                    process = self.start(stderr=terminal.slave)
                    terminal.wait_for(stage)
                    self.kill(process)
                over += self.check()
        self.assertLess(over, len(stages) / 2, "the kills come too late")

    def named_stages(self):
        with Terminal() as terminal:
            process = self.start(stderr=terminal.slave)
            seen = terminal.read_until(lambda text: process.poll() is not None)
        self.assertEqual(process.returncode, 0)
        self.put_old_world()
        return {line.split("% ")[-1] for line in seen.replace("\x1b[K", "").split("\r") if "% " in line}

    def test_while_it_commits(self):
        fresh = self.beside / "world"
        moments = {
            "the index is written": lambda: (fresh / "world.zcw").exists(),
            "the report is written": lambda: (fresh / "bake.json").exists(),
            "the names change": lambda: self.world.stat().st_ino != inode,
        }
        for name, reached in moments.items():
            with self.subTest(moment=name):
                inode = self.world.stat().st_ino
                process = self.start()
                while process.poll() is None and not reached():
                    pass
                self.kill(process)
                is_new = self.check()
                if name == "the names change":
                    self.assertTrue(is_new)

    def test_without_an_old_world(self):
        for moment in range(5):
            shutil.rmtree(self.world)
            process = self.start()
            time.sleep(self.whole_s * (moment + 0.5) / 5)
            self.kill(process)
            if self.world.exists():
                self.assertEqual(content(self.world), self.new_bytes)
            self.zonecast(*self.bake(self.new_city, self.world))
            self.assertEqual(content(self.world), self.new_bytes)
            self.assertFalse(self.beside.exists())

    def test_a_second_bake_at_once_is_refused_and_harms_nothing(self):
        with Terminal() as terminal:
            first = self.start(stderr=terminal.slave)
            terminal.wait_for("simplify")
            first.send_signal(signal.SIGSTOP)
            try:
                self.assert_refused(self.bake(self.old_city, self.world), 1, self.world,
                                    "another bake is writing this world")
                self.assertTrue((self.beside / "world").exists())
            finally:
                first.send_signal(signal.SIGCONT)
            terminal.read_until(lambda text: first.poll() is not None)
        self.assertEqual(first.returncode, 0)
        self.assertEqual(content(self.world), self.new_bytes)


class Terminal:
    """What a process sees as a terminal, where it shows its stages."""

    def __enter__(self):
        self.master, self.slave = pty.openpty()
        os.set_blocking(self.master, False)
        self.text = ""
        return self

    def __exit__(self, *_):
        os.close(self.master)
        os.close(self.slave)

    def wait_for(self, stage):
        self.read_until(lambda text: f"% {stage}" in text)

    def read_until(self, done, timeout_s=60):
        give_up = time.monotonic() + timeout_s
        while not done(self.text):
            if time.monotonic() > give_up:
                raise AssertionError(f"not reached within {timeout_s} s: {self.text!r}")
            self.drain()
        self.drain()
        return self.text

    def drain(self):
        try:
            self.text += os.read(self.master, 1 << 16).decode()
        except BlockingIOError:
            time.sleep(0.0005)


def content(world):
    """All of a world but the report of how long it took."""
    found = support.snapshot(world)
    del found["bake.json"]
    return found


if __name__ == "__main__":
    support.main()
