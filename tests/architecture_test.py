# SPDX-License-Identifier: Apache-2.0
"""The house's arrows, held to #include lines and CMake's link lines.

base and shaders/shared need nothing; streamer and runtime never see each other; baker sees the world format alone;
replay composes. CGAL and OpenMesh, and with them the GPL, stay in baker/ and its tests.
"""

import pathlib
import re
import unittest

SOURCES = pathlib.Path(__file__).resolve().parents[1]
ROOMS = ("base", "baker", "streamer", "runtime", "shaders", "replay", "tests")
CODE = (".h", ".cpp", ".glsl", ".py", ".sh")

# Room -> where its own includes may point. A file counts to the longest name that its path begins with.
ARROWS = {
    "base": ("base",),
    "shaders/shared": ("shaders/shared",),
    "shaders": ("shaders",),
    "streamer/world_format": ("base", "shaders/shared", "streamer/world_format"),
    "streamer": ("base", "shaders/shared", "streamer"),
    "runtime": ("base", "shaders/shared", "runtime"),
    "baker": ("base", "shaders/shared", "streamer/world_format", "baker"),
    "replay": ("base", "shaders/shared", "streamer", "runtime", "replay"),
    "tests": ROOMS,
}
# The composition root's commands that join the baker; no other file outside baker/ and its tests may.
JOINS_BAKER = ("replay/bench_subject.cpp", "replay/bench_subject.h", "replay/bvh_option.h", "replay/command_bake.cpp",
               "replay/command_bench_build.cpp", "replay/command_bench_top_level.cpp", "replay/command_bench_trace.cpp", "replay/command_generate.cpp")

# Library -> the rooms whose files may include it.
LIBRARIES = {
    "CGAL/": ("baker",),
    "OpenMesh/": ("baker",),
    "stb/": ("baker", "replay"),
    "tbb/": ("baker", "tests"),
    "tiny_gltf.h": ("baker",),
    "pugixml.hpp": ("baker",),
    "meshoptimizer.h": ("baker", "tests"),
    "draco/": ("baker", "tests"),
    "xxhash.h": ("baker", "streamer", "tests"),
    "nlohmann/": ("baker", "streamer", "replay", "tests"),
    "glm/": ("baker", "streamer", "runtime", "replay", "tests"),
    "vulkan/": ("runtime", "replay"),
    "CLI/": ("replay",),
    "embree3/": ("baker", "replay"),
    "spdlog/": ("replay",),
    "md5.h": ("streamer",),
    "curl/": ("streamer",),
    "zip.h": ("replay",),
    "httplib.h": ("replay",),
    "spng.h": ("replay", "tests"),
    "gtest/": ("tests",),
    "spirv_cross/": ("tests",),
}
POSIX = {"fcntl.h", "malloc.h", "netdb.h", "netinet/in.h", "netinet/tcp.h", "poll.h", "pthread.h", "signal.h",
         "stdio.h", "stdlib.h", "unistd.h"}

# Target -> what it may link. Anything else is a new arrow, to be drawn here on purpose.
LINKS = {
    "zonecast_base": {"zonecast_options"},
    "zonecast_streamer": {"zonecast_base", "glm::glm", "Threads::Threads",
                          "nlohmann_json::nlohmann_json", "PkgConfig::XXHASH", "PkgConfig::MD", "CURL::libcurl"},
    "zonecast_runtime": {"zonecast_base", "glm::glm", "Vulkan::Vulkan"},
    "zonecast_baker": {"zonecast_streamer", "CGAL::CGAL", "OpenMeshCore", "OpenMeshTools", "draco::draco",
                       "nlohmann_json::nlohmann_json", "PkgConfig::XXHASH", "TBB::tbb", "embree", "meshoptimizer::meshoptimizer",
                       "pugixml::pugixml"},
    "zonecast_replay": {"zonecast_streamer", "zonecast_runtime", "CLI11::CLI11", "nlohmann_json::nlohmann_json",
                        "PkgConfig::SPNG", "PkgConfig::MINIZIP", "PkgConfig::HTTPLIB", "spdlog::spdlog", "spdlog::spdlog_header_only", "embree"},
    "zonecast": {"zonecast_replay", "zonecast_baker"},
}
# Target -> the folders whose sources it is made of.
HOMES = {"zonecast_base": "base", "zonecast_streamer": "streamer", "zonecast_runtime": "runtime",
         "zonecast_baker": "baker", "zonecast_replay": "replay", "zonecast": "replay"}

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
SPDX = re.compile(r"^(?://|#) SPDX-License-Identifier: (\S+)$")


def source_files():
    return sorted(path.relative_to(SOURCES).as_posix() for room in ROOMS for path in (SOURCES / room).rglob("*")
                  if path.suffix in CODE)


def read(name):
    return (SOURCES / name).read_text(encoding="utf-8")


def room_of(name):
    return max((room for room in ARROWS if name.startswith(room + "/")), key=len)


def belongs_to_baker(name, text):
    """Whether a file is of the baker or, for a test, includes it: at once or through another test's header."""
    if name.startswith(("baker/", "tests/unit/baker/")):
        return True
    if not name.startswith("tests/"):
        return False
    targets = [target for _, target in INCLUDE.findall(text)]
    return any(target.startswith("baker/") or (target.startswith("tests/") and target != name
                                               and (SOURCES / target).is_file()
                                               and belongs_to_baker(target, read(target))) for target in targets)


def include_faults(name, text):
    """What is wrong with a file's #include lines."""
    return [f"{name}: {fault}: {target}" for bracket, target in INCLUDE.findall(text)
            if (fault := angle_fault(name, target) if bracket == "<" else quote_fault(name, target))]


def angle_fault(name, target):
    if target in POSIX or target.startswith("sys/") or re.fullmatch(r"[a-z_0-9]+", target):
        return None
    library = next((library for library in LIBRARIES if target.startswith(library)), None)
    if library is None:
        return "neither the standard's nor a library of ours"
    if name.split("/")[0] not in LIBRARIES[library]:
        return "library not for this room"
    return None


def quote_fault(name, target):
    room = room_of(name)
    if target.startswith("spirv/"):  # made by the build from shaders/
        return None if room == "runtime" else "compiled shaders are the runtime's"
    beside = (pathlib.PurePosixPath(name).parent / target).as_posix()
    if room.startswith("shaders") and not (SOURCES / target).is_file():
        target = beside if (SOURCES / beside).is_file() else f"shaders/{target}"
    if not (SOURCES / target).is_file():
        return "no such file from the sources' top"
    if target.startswith("baker/") and name in JOINS_BAKER:
        return None
    if not any(target.startswith(allowed + "/") for allowed in ARROWS[room]):
        return f"{room} must not know it"
    return None


def license_fault(name, text):
    lines = text.splitlines()
    first = lines[1] if lines and lines[0].startswith("#!") and len(lines) > 1 else (lines or [""])[0]
    found = SPDX.match(first)
    if not found:
        return f"{name}: does not begin with its SPDX line"
    wanted = "GPL-3.0-or-later" if belongs_to_baker(name, text) else "Apache-2.0"
    return None if found[1] == wanted else f"{name}: is {found[1]}, its place asks for {wanted}"


class Build:
    """What CMakeLists.txt says of targets, as far as the arrows go."""

    def __init__(self, text):
        self.sources, self.links, self.shaders = {}, {}, set()
        text = re.sub(r"#.*", "", text)
        for command, body in re.findall(r"\b(\w+)\s*\(([^()]*(?:\([^()]*\)[^()]*)*)\)", text):
            words = body.split()
            if command in ("add_library", "add_executable") and words and "${" not in words[0]:
                self.sources[words[0]] = [word for word in words if word.endswith(".cpp")]
            elif command == "target_link_libraries" and "${" not in words[0]:
                links = {word for word in words[1:] if word not in ("PUBLIC", "PRIVATE", "INTERFACE")}
                self.links.setdefault(words[0], set()).update(links)
            elif command == "zonecast_test" and "LINKS" in words:
                self.sources[words[0]] = [word for word in words if word.endswith(".cpp")]
                self.links[words[0]] = set(words[words.index("LINKS") + 1 :])
            elif command == "set" and words[0] in ("SHADERS", "SHADER_INCLUDES"):
                names = words[1:] if words[0] == "SHADER_INCLUDES" else [f"shaders/{word}.glsl" for word in words[1:]]
                self.shaders.update(names)


class Architecture(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.files = {name: read(name) for name in source_files()}
        cls.build = Build(read("CMakeLists.txt"))

    def test_includes_follow_the_arrows(self):
        faults = [fault for name, text in self.files.items() for fault in include_faults(name, text)]
        self.assertEqual(faults, [])

    def test_every_file_begins_with_the_licence_of_its_place(self):
        others = {name: read(name) for name in ("CMakeLists.txt", ".ci/run")}
        faults = [license_fault(name, text) for name, text in {**self.files, **others}.items()]
        self.assertEqual([fault for fault in faults if fault], [])

    def test_link_lines_follow_the_arrows(self):
        for target, allowed in LINKS.items():
            self.assertIn(target, self.build.links)
            self.assertEqual(self.build.links[target] - allowed, set(), f"{target} must not link this")

    def test_no_target_is_unknown_and_tests_that_link_the_baker_are_under_the_gpl(self):
        for target, links in self.build.links.items():
            if target in (*LINKS, "zonecast_options"):
                continue
            sources = self.build.sources[target]
            self.assertTrue(all(source.startswith("tests/") for source in sources), f"{target} is no test")
            if "zonecast_baker" in links:
                for source in sources:
                    self.assertTrue(belongs_to_baker(source, self.files[source]), f"{source} needs no baker")

    def test_every_source_is_built_once_and_at_home(self):
        listed = [source for sources in self.build.sources.values() for source in sources]
        self.assertEqual(sorted(listed), sorted(name for name in self.files if name.endswith(".cpp")))
        for target, home in HOMES.items():
            for source in self.build.sources[target]:
                self.assertTrue(source.startswith(home + "/"), f"{source} is in {target}")
        for source in (name for name in JOINS_BAKER if name.endswith(".cpp")):
            self.assertIn(source, self.build.sources["zonecast"])

    def test_every_shader_is_built(self):
        shaders = {name for name in self.files if name.startswith("shaders/")}
        self.assertEqual(self.build.shaders, shaders)

    def test_every_end_to_end_test_is_run(self):
        text = read("CMakeLists.txt")
        for name in self.files:
            if found := re.fullmatch(r"tests/e2e/(\w+)_test\.py", name):
                self.assertRegex(text, rf"\b{found[1]}\b")


class TheChecksThemselves(unittest.TestCase):
    """Each arrow against the grain is caught."""

    def test_forbidden_includes(self):
        for name, line in (
            ("base/a.h", '#include "streamer/streamer.h"'), ("base/a.h", "#include <glm/vec3.hpp>"),
            ("shaders/shared/a.h", '#include "base/check.h"'), ("streamer/a.cpp", '#include "runtime/renderer.h"'),
            ("streamer/a.cpp", "#include <vulkan/vulkan.h>"), ("streamer/a.cpp", '#include "baker/bake.h"'),
            ("streamer/world_format/a.h", '#include "streamer/streamer.h"'),
            ("runtime/a.h", "#  include <draco/mesh/mesh.h>"),
            ("runtime/a.h", "#include <nlohmann/json.hpp>"), ("runtime/a.h", '#include "streamer/source.h"'),
            ("runtime/a.h", '#include "streamer/world_format/world_index.h"'), ("runtime/a.h", "#include <spng.h>"),
            ("baker/a.cpp", '#include "streamer/streamer.h"'), ("baker/a.cpp", "#include <vulkan/vulkan.h>"),
            ("baker/a.cpp", '#include "replay/units.h"'), ("replay/a.cpp", '#include "baker/bake.h"'),
            ("replay/command_bake.cpp", "#include <CGAL/Surface_mesh.h>"),
            ("replay/a.cpp", "#include <OpenMesh/Core/x.hh>"),
            ("replay/a.cpp", '#include "spirv/trace_rays.comp.h"'), ("replay/a.cpp", "#include <curl/curl.h>"),
            ("streamer/a.cpp", '#include "draco/mesh/mesh.h"'), ("streamer/a.cpp", '#include "nowhere.h"'),
        ):
            self.assertEqual(len(include_faults(name, line)), 1, (name, line))

    def test_allowed_includes(self):
        for name, line in (
            ("base/a.h", "#include <vector>"), ("base/a.h", "#include <sys/stat.h>"),
            ("streamer/a.cpp", '#include "shaders/shared/page.h"'), ("runtime/a.h", '#include "shaders/shared/page.h"'),
            ("baker/a.cpp", '#include "streamer/world_format/world_index.h"'), ("baker/a.cpp", "#include <CGAL/x.h>"),
            ("replay/command_bake.cpp", '#include "baker/bake.h"'), ("shaders/shared/page.h", '#include "shared.h"'),
            ("tests/unit/baker/a.cpp", '#include "baker/bake.h"'), ("streamer/a.cpp", "// #include <vulkan/vulkan.h>"),
        ):
            self.assertEqual(include_faults(name, line), [], (name, line))

    def test_wrong_licences(self):
        apache, gpl = "// SPDX-License-Identifier: Apache-2.0\n", "// SPDX-License-Identifier: GPL-3.0-or-later\n"
        self.assertIsNone(license_fault("streamer/a.cpp", apache))
        self.assertIsNone(license_fault("baker/a.cpp", gpl))
        self.assertIsNone(license_fault("tests/e2e/a.sh", "#!/bin/sh\n# SPDX-License-Identifier: Apache-2.0\n"))
        self.assertIsNone(license_fault("tests/numerics/a.cpp", gpl + '#include "baker/bake.h"\n'))
        for name, text in (("streamer/a.cpp", gpl), ("baker/a.cpp", apache), ("streamer/a.cpp", "\n" + apache),
                           ("streamer/a.cpp", ""), ("tests/golden/a.cpp", gpl),
                           ("tests/numerics/a.cpp", apache + '#include "baker/bake.h"\n')):
            self.assertIsNotNone(license_fault(name, text), (name, text))

    def test_build_lines_are_read(self):
        build = Build("add_library(a STATIC\n  x.cpp  # y.cpp\n  z.cpp)\ntarget_link_libraries(a PUBLIC b PRIVATE c)\n"
                      "zonecast_test(t SOURCES t.cpp\n LINKS a b)\nset(SHADERS one.comp)")
        self.assertEqual(build.sources, {"a": ["x.cpp", "z.cpp"], "t": ["t.cpp"]})
        self.assertEqual(build.links, {"a": {"b", "c"}, "t": {"a", "b"}})
        self.assertEqual(build.shaders, {"shaders/one.comp.glsl"})


if __name__ == "__main__":
    unittest.main(verbosity=2)
