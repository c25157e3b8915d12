# SPDX-License-Identifier: Apache-2.0
"""The layout's dependencies, held to #include lines and to CMakeLists.txt.

CMakeLists.txt declares a library a folder and whom it may include (MODULES). Here: includes are just those, nothing is
declared for nothing, there is no cycle, and the large modules keep apart. base and shaders/shared need nothing; streamer
and runtime meet at the interface streamer/page_sink.h alone; baker sees the world format and the sources alone; replay composes. CGAL and
OpenMesh, and with them the GPL, stay in baker/ and its tests.
"""

import pathlib
import re
import unittest

SOURCES = pathlib.Path(__file__).resolve().parents[1]
TOP = ("base", "baker", "streamer", "runtime", "shaders", "replay", "tests")
CODE = (".h", ".cpp", ".glsl", ".py", ".sh")

# Headers alone: they belong to no library, or to their parent's.
HEADERS = {
    "shaders/shared": (),
    "streamer/page_sink.h": ("base",),
    "streamer/world_format/coding": ("shaders/shared", "streamer/world_format"),
}
# Every module may include these.
EVERYBODY = ("shaders/shared", "streamer/page_sink.h", "streamer/world_format/coding")
# Large module -> what its modules may declare: a folder with all below it.
LAYERS = {
    "base": (),
    "streamer": ("base", "streamer"),
    "runtime": ("base", "runtime"),
    "baker": ("base", "streamer/world_format", "streamer/draco", "streamer/source", "baker"),
    "replay": ("base", "streamer", "runtime", "replay"),
}
# The binary's commands, the only ones outside baker/ and its tests that may include the baker.
COMMANDS = "replay/cli"
FOLDER_LIMIT = 15  # translation units

# Library -> the large modules whose files may include it.
LIBRARIES = {
    "CGAL/": ("baker",),
    "OpenMesh/": ("baker",),
    "stb/": ("baker", "replay"),
    "tbb/": ("baker", "tests"),
    "tiny_gltf.h": ("baker",),
    "tiny_obj_loader.h": ("baker",),
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
    "unzip.h": ("baker",),
    "proj.h": ("baker",),
    "zlib.h": ("baker", "tests"),
    "zstd.h": ("baker", "tests"),
    "httplib.h": ("replay",),
    "spng.h": ("baker", "replay", "tests"),
    "turbojpeg.h": ("baker", "tests"),
    "webp/": ("baker", "tests"),
    "gtest/": ("tests",),
    "spirv_cross/": ("runtime", "tests"),
}
POSIX = {"fcntl.h", "malloc.h", "netdb.h", "netinet/in.h", "netinet/tcp.h", "poll.h", "pthread.h", "signal.h",
         "stdio.h", "stdlib.h", "unistd.h"}

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
SPDX = re.compile(r"^(?://|#) SPDX-License-Identifier: (\S+)$")


def source_files():
    """tests/embed is a project of its own, against the installed package."""
    found = (path.relative_to(SOURCES).as_posix() for top in TOP for path in (SOURCES / top).rglob("*")
             if path.suffix in CODE)
    return sorted(name for name in found if not name.startswith("tests/embed/"))


def read(name):
    return (SOURCES / name).read_text(encoding="utf-8")


class Build:
    """What CMakeLists.txt says of targets, as far as dependencies go."""

    def __init__(self, text):
        self.modules, self.sources, self.links, self.shaders = {}, {}, {}, set()
        text = re.sub(r"#.*", "", text)
        for command, body in re.findall(r"\b(\w+)\s*\(([^()]*(?:\([^()]*\)[^()]*)*)\)", text):
            words = body.split()
            if command == "zonecast_library" and "${" not in words[0]:
                keys = {}
                for word in words[1:]:
                    key = word if word in ("SOURCES", "MODULES", "PUBLIC", "PRIVATE") else key
                    keys.setdefault(key, []).extend([] if word == key else [word])
                target = "zonecast_" + words[0].replace("/", "_")
                self.modules[words[0]] = keys.get("MODULES", [])
                self.sources[target] = [f"{words[0]}/{word}" for word in keys["SOURCES"]
                                        if word.endswith(".cpp") and "${" not in word]
                self.links[target] = set(keys.get("PUBLIC", []) + keys.get("PRIVATE", []))
            elif command in ("add_library", "add_executable") and words and "${" not in words[0]:
                self.sources[words[0]] = [word for word in words if word.endswith(".cpp")]
            elif command == "target_link_libraries" and "${" not in words[0]:
                links = {word for word in words[1:] if word not in ("PUBLIC", "PRIVATE", "INTERFACE")}
                self.links.setdefault(words[0], set()).update(links)
            elif command == "zonecast_test" and "LINKS" in words:
                self.sources[words[0]] = [word for word in words if word.endswith(".cpp")]
                self.links[words[0]] = set(words[words.index("LINKS") + 1 :])
            elif command == "set" and words[0] == "SHADER_INCLUDES":
                self.shaders.update(words[1:])
            elif command == "set" and words[0] == "PASSES":  # a source and a shader each
                self.sources["passes"] = [f"runtime/passes/{word}.cpp" for word in words[1:]]
                self.shaders.update(f"shaders/passes/{word}.comp.glsl" for word in words[1:])
            elif command == "zonecast_shaders" and "${" not in words[0]:
                self.shaders.update(f"shaders/{word}.glsl" for word in words[1:] if "${" not in word)

    def module_of(self, name):
        """The longest declared folder, or header, that a path lies in."""
        known = [m for m in (*self.modules, *HEADERS, COMMANDS, "tests") if name == m or name.startswith(m + "/")]
        return max(known, key=len, default=name.split("/")[0])

    def may_include(self, name):
        """None: whatever there is."""
        module = self.module_of(name)
        if module in (COMMANDS, "tests"):
            return None
        return (module, *self.modules.get(module, HEADERS.get(module, ())), *(
            () if module in HEADERS or module == "base" else EVERYBODY))


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


def include_faults(name, text, build):
    """What is wrong with a file's #include lines."""
    return [f"{name}: {fault}: {target}" for bracket, target in INCLUDE.findall(text)
            if (fault := angle_fault(name, target) if bracket == "<" else quote_fault(name, target, build))]


def angle_fault(name, target):
    if target in POSIX or target.startswith("sys/") or re.fullmatch(r"[a-z_0-9]+", target):
        return None
    library = next((library for library in LIBRARIES if target.startswith(library)), None)
    if library is None:
        return "neither the standard's nor a library of ours"
    if name.split("/")[0] not in LIBRARIES[library]:
        return "library not for this module"
    return None


def quote_fault(name, target, build):
    if target.startswith("spirv/"):  # made by the build from shaders/
        allowed = name.startswith(("runtime/", "replay/host/", "replay/bench/", "tests/"))
        return None if allowed else "compiled shaders are the runtime's, the stand-in host's and the benchmarks'"
    if name.startswith("shaders/"):
        beside = (pathlib.PurePosixPath(name).parent / target).as_posix()
        target = next((path for path in (beside, f"shaders/{target}", target) if (SOURCES / path).is_file()), "")
        allowed = "shaders/shared/" if name.startswith("shaders/shared/") else "shaders/"
        return None if target.startswith(allowed) else "shaders include shaders alone"
    if not (SOURCES / target).is_file():
        return "no such file from the sources' top"
    allowed = build.may_include(name)
    if allowed is None or build.module_of(target) in allowed:
        return None
    return f"{build.module_of(name)} does not declare {build.module_of(target)}"


def license_fault(name, text):
    lines = text.splitlines()
    first = lines[1] if lines and lines[0].startswith("#!") and len(lines) > 1 else (lines or [""])[0]
    found = SPDX.match(first)
    if not found:
        return f"{name}: does not begin with its SPDX line"
    wanted = "GPL-3.0-or-later" if belongs_to_baker(name, text) else "Apache-2.0"
    return None if found[1] == wanted else f"{name}: is {found[1]}, its place asks for {wanted}"


class Architecture(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.files = {name: read(name) for name in source_files()}
        cls.build = Build(read("CMakeLists.txt"))

    def test_includes_follow_the_declared_dependencies(self):
        faults = [fault for name, text in self.files.items() for fault in include_faults(name, text, self.build)]
        self.assertEqual(faults, [])

    def test_no_dependency_is_declared_for_nothing(self):
        for module, declared in self.build.modules.items():
            text = [text for name, text in self.files.items() if self.build.module_of(name) == module]
            used = {self.build.module_of(target) for t in text for bracket, target in INCLUDE.findall(t)
                    if bracket == '"'}
            self.assertEqual(set(declared) - used - {"base"}, set(), f"{module} includes none of these")

    def test_modules_have_no_cycle(self):
        order = []
        while len(order) < len(self.build.modules):
            ready = [m for m, needs in self.build.modules.items() if m not in order and all(n in order for n in needs)]
            self.assertNotEqual(ready, [], f"a cycle among {sorted(set(self.build.modules) - set(order))}")
            order += ready

    def test_large_modules_keep_apart(self):
        for module, declared in self.build.modules.items():
            allowed = LAYERS[module.split("/")[0]]
            for name in declared:
                self.assertTrue(any(name == a or name.startswith(a + "/") for a in allowed), f"{module} -> {name}")

    def test_folders_are_small(self):
        folders = [name.rsplit("/", 1)[0] for name in self.files if name.endswith(".cpp")]
        large = {folder for folder in folders if folders.count(folder) > FOLDER_LIMIT}
        self.assertEqual(large, set())

    def test_every_file_begins_with_the_licence_of_its_place(self):
        others = {name: read(name) for name in ("CMakeLists.txt", ".ci/run", "tests/embed/main.cpp",
                                                "tests/embed/check_picture.h", "tests/embed/gbuffer.comp.glsl")}
        faults = [license_fault(name, text) for name, text in {**self.files, **others}.items()]
        self.assertEqual([fault for fault in faults if fault], [])

    def test_only_the_binary_and_tests_under_the_gpl_link_the_baker(self):
        for target, links in self.build.links.items():
            if not any(link.startswith("zonecast_baker") for link in links) or target == "zonecast":
                continue
            for source in self.build.sources[target]:
                self.assertTrue(belongs_to_baker(source, self.files[source]), f"{source} needs no baker")

    def test_every_source_is_built_once_and_in_the_library_of_its_folder(self):
        listed = [source for sources in self.build.sources.values() for source in sources]
        self.assertEqual(sorted(listed), sorted(name for name in self.files if name.endswith(".cpp")))
        for source in self.build.sources["zonecast"]:
            self.assertTrue(source.startswith(COMMANDS + "/"), source)

    def test_every_shader_is_built(self):
        shaders = {name for name in self.files if name.startswith("shaders/")}
        self.assertEqual(self.build.shaders, shaders)

    def test_every_end_to_end_test_is_run(self):
        text = read("CMakeLists.txt")
        for name in self.files:
            if found := re.fullmatch(r"tests/e2e/(\w+)_test\.py", name):
                self.assertRegex(text, rf"\b{found[1]}\b")


class TheChecksThemselves(unittest.TestCase):
    """Each dependency against the order is caught."""

    BUILD = Build(read("CMakeLists.txt"))

    def test_forbidden_includes(self):
        for name, line in (
            ("base/a.h", '#include "streamer/streamer.h"'), ("base/a.h", "#include <glm/vec3.hpp>"),
            ("shaders/shared/a.h", '#include "base/check.h"'), ("streamer/a.cpp", '#include "runtime/scene/zone_set.h"'),
            ("streamer/a.cpp", "#include <vulkan/vulkan.h>"), ("streamer/a.cpp", '#include "baker/bake.h"'),
            ("streamer/world_format/a.h", '#include "streamer/streamer.h"'),
            ("streamer/paging/a.h", '#include "streamer/statistics/statistics.h"'),
            ("baker/cut/a.h", '#include "baker/proxy/simplify.h"'),
            ("baker/distance/a.h", '#include "baker/proxy/simplify.h"'),
            ("runtime/a.h", "#  include <draco/mesh/mesh.h>"),
            ("runtime/a.h", "#include <nlohmann/json.hpp>"), ("runtime/a.h", '#include "streamer/source/source.h"'),
            ("runtime/a.h", '#include "streamer/world_format/world_index.h"'), ("runtime/a.h", "#include <spng.h>"),
            ("baker/a.cpp", '#include "streamer/streamer.h"'), ("baker/a.cpp", "#include <vulkan/vulkan.h>"),
            ("baker/a.cpp", '#include "replay/session/units.h"'), ("replay/session/a.cpp", '#include "baker/bake.h"'),
            ("replay/image/a.cpp", '#include "replay/paths/camera_path.h"'),
            ("replay/cli/command_bake.cpp", "#include <CGAL/Surface_mesh.h>"),
            ("replay/a.cpp", "#include <OpenMesh/Core/x.hh>"),
            ("replay/a.cpp", '#include "spirv/trace_rays.comp.h"'), ("replay/a.cpp", "#include <curl/curl.h>"),
            ("streamer/a.cpp", '#include "draco/mesh/mesh.h"'), ("streamer/a.cpp", '#include "nowhere.h"'),
        ):
            self.assertEqual(len(include_faults(name, line, self.BUILD)), 1, (name, line))

    def test_allowed_includes(self):
        for name, line in (
            ("base/a.h", "#include <vector>"), ("base/a.h", "#include <sys/stat.h>"),
            ("streamer/a.cpp", '#include "shaders/shared/page.h"'), ("runtime/a.h", '#include "shaders/shared/page.h"'),
            ("runtime/scene/a.h", '#include "streamer/page_sink.h"'),
            ("baker/a.cpp", '#include "streamer/world_format/world_index.h"'), ("baker/a.cpp", "#include <CGAL/x.h>"),
            ("replay/cli/command_bake.cpp", '#include "baker/bake.h"'), ("shaders/shared/page.h", '#include "shared.h"'),
            ("tests/unit/baker/a.cpp", '#include "baker/bake.h"'), ("streamer/a.cpp", "// #include <vulkan/vulkan.h>"),
        ):
            self.assertEqual(include_faults(name, line, self.BUILD), [], (name, line))

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
        build = Build("zonecast_library(a/b\n  SOURCES x.cpp  # y.cpp\n  z.cpp\n  MODULES base c/d PRIVATE e)\n"
                      "zonecast_test(t SOURCES t.cpp\n LINKS a b)\nzonecast_shaders(p ${X} one.comp)\nset(PASSES two)")
        self.assertEqual(build.modules, {"a/b": ["base", "c/d"]})
        self.assertEqual(build.sources, {"zonecast_a_b": ["a/b/x.cpp", "a/b/z.cpp"], "t": ["t.cpp"],
                                         "passes": ["runtime/passes/two.cpp"]})
        self.assertEqual(build.links, {"zonecast_a_b": {"e"}, "t": {"a", "b"}})
        self.assertEqual(build.shaders, {"shaders/one.comp.glsl", "shaders/passes/two.comp.glsl"})


if __name__ == "__main__":
    unittest.main(verbosity=2)
