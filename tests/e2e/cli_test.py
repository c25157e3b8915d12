# SPDX-License-Identifier: Apache-2.0
"""What all commands have in common: --json [FILE], and a --help of one screen."""
import json
import struct
import subprocess

import support

HELP_LINES, HELP_COLUMNS, OPTION_LINES = 55, 110, 2
COMMANDS = ((), ("generate",), ("bake",), ("inspect",), ("pack",), ("serve",), ("caps",), ("compare",), ("replay",), ("bench",),
            ("bench", "build"), ("bench", "trace"), ("bench", "top-level"), ("bench", "paging"))
REPORTS = [command for command in COMMANDS if command not in ((), ("bench",))]


class Json(support.Case):
    @classmethod
    def prepare(cls):
        cls.world = cls.folder / "world"
        cls.bake_small_city(cls.world)
        cls.city = cls.folder / "city.json"
        support.small_drive(cls.folder / "drive.csv")
        cls.triangles = cls.folder / "quad.tris"
        square = (-9, -9, 0, 9, -9, 0, 9, 9, 0, -9, -9, 0, 9, 9, 0, -9, 9, 0)
        cls.triangles.write_bytes(struct.pack("<18f", *square))
        cls.rays = cls.folder / "one.rays"
        cls.rays.write_bytes(struct.pack("<6f", 1, 2, 5, 0, 0, -1))

    def commands(self):
        """Each command that ends by itself: the words, and a key of its report."""
        path = ("--path", self.folder / "drive.csv")
        return (
            (("generate", "--size-km", "0.1", "-o", self.folder / "generated"), "triangles"),
            (("bake", self.city, "--leaf-triangles", "64", "-o", self.world), "bake_s"),
            (("inspect", self.world), "zones"),
            (("pack", self.world, "-o", self.folder / "world.3tz"), "archive"),
            (("compare", self.world, "--size", "64x36", "--frames", "0:1", *path, "-o", self.folder / "compared"), "levels"),
            (("caps", self.world, *path), "caps"),
            (("replay", self.world, "--no-render", "--cap", "16MiB", *path), "summary"),
            (("bench", "build", "--triangles", self.triangles, "--repeat", "1"), "rows"),
            (("bench", "trace", "--triangles", self.triangles, "--rays", self.rays, "--repeat", "1", "--engines", "bvh2"),
             "rows"),
            (("bench", "top-level", self.world, "--zones", "2", "--repeat", "1"), "rows"),
            (("bench", "paging", "--nodes", "100", "--frames", "2"), "rows"),
        )

    def test_every_command_that_reports_has_the_option(self):
        tried = {words[:2] if words[0] == "bench" else words[:1] for words, _ in self.commands()}
        self.assertEqual(tried | {("serve",)}, set(REPORTS))

    def test_with_a_file_the_text_stays_and_without_it_goes(self):
        for words, key in self.commands():
            with self.subTest(words=words[:2]):
                file = self.folder / "report.json"
                file.unlink(missing_ok=True)
                text = self.zonecast(*words, "--json", file)
                self.assertRegex(text, r"\w")
                self.assertFalse(text.startswith("{"))
                report = json.loads(file.read_text())
                self.assertIn(key, report)
                alone = json.loads(self.zonecast(*words, "--json"))
                self.assertEqual(alone.keys(), report.keys())

    def test_the_text_is_that_of_a_run_without_the_option(self):
        file = self.folder / "inspected.json"
        self.assertEqual(self.zonecast("inspect", self.world), self.zonecast("inspect", self.world, "--json", file))
        self.assertEqual(self.zonecast("inspect", self.world, "--json", "-"), file.read_text())

    def test_a_word_behind_it_is_the_world_where_none_is_named(self):
        for words in (("--json", self.world), ("--json", self.world, "--verify"), ("--verify", "--json", self.world)):
            self.assertIn("zones", json.loads(self.zonecast("inspect", *words)))
        file = self.folder / "first.json"
        self.assertIn("zones", self.zonecast("inspect", "--json", file, self.world))
        self.assertIn("zones", json.loads(file.read_text()))
        self.assert_refused(["inspect", "--json"], 2, "world")

    def test_a_bake_reports_over_no_city(self):
        self.assert_refused(["bake", "--json", self.city, self.city, "-o", self.folder / "none"], 2, "city.json")

    def test_a_file_that_cannot_be_written(self):
        done = self.run_zonecast("inspect", self.world, "--json", self.folder / "no" / "such" / "folder.json")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertIn("folder.json", done.stderr)

    def test_serve_says_where_it_listens(self):
        for words in (("serve", self.world, "--port", "0", "--json"), ("serve", "--json", self.world, "--port", "0")):
            with subprocess.Popen([support.BINARY, *map(str, words)], stdout=subprocess.PIPE, text=True) as server:
                lines = [server.stdout.readline() for _ in range(4)]
                server.terminate()
                self.assertEqual(server.wait(timeout=30), 0)
            self.assertRegex(json.loads("".join(lines))["url"], r"^http://127\.0\.0\.1:\d+/$")


class Help(support.Case):
    def test_it_is_one_screen(self):
        for command in COMMANDS:
            with self.subTest(command=command):
                lines = self.zonecast(*command, "--help").splitlines()
                self.assertLessEqual(len(lines), HELP_LINES)
                self.assertLessEqual(max(map(len, lines)), HELP_COLUMNS)
                self.assertFalse([line for line in lines if line.startswith(" ") and not line.startswith("  ")])

    def test_what_an_option_does_takes_two_lines(self):
        for command in COMMANDS:
            taken = 0
            for line in self.zonecast(*command, "--help").splitlines():
                if line[:3].strip():  # a name, and what it does where that begins on the same line
                    taken = 1 if line[28:30] == "  " and line[30:] else 0
                else:
                    taken += line.startswith(" " * 30)
                with self.subTest(command=command, line=line):
                    self.assertLessEqual(taken, OPTION_LINES)

    def test_the_report_is_explained_once(self):
        self.assertIn("--json [FILE]", "\n".join(self.zonecast("--help").splitlines()[-3:]))
        for command in REPORTS:
            with self.subTest(command=command):
                self.assertEqual(self.zonecast(*command, "--help").count("--json [FILE]"), 1)


class Words(support.Case):
    def refusal(self, *words):
        done = subprocess.run([support.BINARY, *words], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (2, ""), words)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        return done.stderr

    def test_a_command_that_there_is_none_of_is_named_with_the_nearest(self):
        self.assertIn("'bkae' is no command; did you mean 'bake'?", self.refusal("bkae", "a.gml"))
        self.assertIn("'bench pagin' is no command; did you mean 'paging'?", self.refusal("bench", "pagin"))
        self.assertIn("'frobnicate' is no command; there are generate, bake,", self.refusal("frobnicate"))
        self.assertIn("'hlep' is no command", self.refusal("hlep"))

    def test_help_of_a_command_is_its_help(self):
        self.assertEqual(self.zonecast("help"), self.zonecast("--help"))
        for command in COMMANDS[1:]:
            self.assertEqual(self.zonecast("help", *command), self.zonecast(*command, "--help"), command)
        self.assertIn("'bkae' is no command", self.refusal("help", "bkae"))


    def test_a_value_that_there_is_none_of_is_named_with_those_there_are_and_the_nearest(self):
        replay = ("replay", "world", "--cap", "8MiB")
        for words, named in (
            ((*replay, "--clock", "wal"), "--clock: 'wal' is none of virtual|wall; did you mean 'wall'?"),
            ((*replay, "--clock", "sundial"), "--clock: 'sundial' is none of virtual|wall\n"),
            ((*replay, "--prediction", "paht"), "path|velocity; did you mean 'path'?"),
            ((*replay, "--reflections", "ful"), "ssr+proxy|proxy|full|none; did you mean 'full'?"),
            ((*replay, "--debug-views", "bvh,norml"), "'norml' is none of provenance|bvh|normals|depth; did you mean 'normals'?"),
            ((*replay, "--kernel", "packet64"), "no kernel is called 'packet64' (auto, measure, or packets64|"),
            ((*replay, "--kernel", "packet64"), "; did you mean 'packets64'?"),
            ((*replay, "--progress", "line"), "auto|bar|lines|none; did you mean 'lines'?"),
            (("bake", "a.gml", "-o", "b", "--progress", "foo"), "'foo' is none of auto|bar|lines|none\n"),
            (("bake", "a.gml", "-o", "b", "--bvh", "swep"), "; did you mean 'sweep'?"),
            (("bench", "trace", "--order", "tile"), "rows|tiles; did you mean 'tiles'?"),
            (("bench", "trace", "--engines", "embre"), "did you mean 'embree'?"),
        ):
            with self.subTest(words=words):
                self.assertIn(named, self.refusal(*words))


class Progress(support.Case):
    @classmethod
    def prepare(cls):
        cls.world = cls.folder / "world"
        cls.bake_small_city(cls.world)
        support.small_drive(cls.folder / "drive.csv")
        cls.bake = ("bake", cls.folder / "city.json", "--leaf-triangles", "64", "-o", cls.world)
        cls.replay = ("replay", cls.world, "--path", cls.folder / "drive.csv", "--cap", "8MiB", "--no-render")

    def test_lines_name_each_stage_on_standard_error_alone(self):
        for words, stages in ((self.bake, ("import", "repair", "cut", "simplify", "light", "bvh", "index")),
                              (self.replay, ("replay",))):
            with self.subTest(words=words[0]):
                done = self.run_zonecast(*words, "--progress", "lines", "--json")
                self.assertEqual(done.returncode, 0, done.stderr)
                json.loads(done.stdout)
                for stage in stages:
                    self.assertRegex(done.stderr, rf"(?m)^zonecast: info: {stage}: done in \d+\.\d s, \d+ % of all$")
                self.assertTrue(done.stderr.rstrip().splitlines()[-1].endswith("100 % of all"), done.stderr)

    def test_short_work_needs_no_lines(self):
        for words in (self.bake, self.replay):
            for more in (("--progress", "auto"), ("--progress", "none")):
                self.assertNotIn("done in", self.run_zonecast(*words, *more).stderr)

    def test_a_bar_is_drawn_where_it_is_asked_for(self):
        for words in (self.bake, self.replay):
            self.assertIn("[####", self.run_zonecast(*words, "--progress", "bar").stderr)

    def test_quiet_is_warnings_errors_and_the_report_that_was_asked_for(self):
        for words in (self.bake, self.replay):
            for more in ((), ("--progress", "lines")):
                done = self.run_zonecast(*words, "--quiet", *more)
                self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
            json.loads(self.zonecast(*words, "--quiet", "--json"))
        done = self.run_zonecast(*self.replay[:-1], "--no-render", "--quiet", "--frames", "90:99")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)


if __name__ == "__main__":
    support.main()
