# SPDX-License-Identifier: Apache-2.0
"""scripts/paper refuses what breaks a rule, by the claim's name, and takes verdicts from results."""
import copy
import importlib.machinery
import importlib.util
import io
import json
import os
import pathlib
import sys
import tempfile
import unittest
from contextlib import redirect_stderr, redirect_stdout

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]


def load(name):
    loader = importlib.machinery.SourceFileLoader(name.replace("-", "_"), str(ROOT / "scripts" / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


paper = load("paper")

CLAIM = {
    "id": "speed", "what": "A step is short", "paper": "14 ms", "figures": {"paper_ms": 14},
    "results": {"ms": "steps[row=1]/ms"}, "ours": "{ms} ms", "command": "runner --quick",
    "tests": ["solver: a step, any step, is taken"], "code": [["solver.h", "int substeps = 10;"]],
    "if": "ms <= paper_ms", "then": ["holds", "{ms} is no more."], "else": ["does not hold", "{ms} is more."],
}
RESULTS = {"steps": [{"row": 1, "ms": 12.5}, {"row": 2, "ms": None}, {"row": 2, "ms": 3}, {"row": 3, "ms": None}],
           "figure3": []}
FILES = {
    "tests/solver/step_test.cpp": 'TEST_CASE("solver: a step, "\n          "any step, is taken", "[unit]") {}\n',
    "include/solver/solver.h": "int   substeps =\n  10;\n",
    "apps/runner/main.cpp": 'app.add_flag("--quick", quick);\n',
    "apps/runner/CMakeLists.txt": "pbdsurg_add_program(runner main.cpp)\n",
    "scripts/lib.sh": "",
}


class House(unittest.TestCase):
    """A repository of one claim."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        (self.root / "docs/pictures").mkdir(parents=True)
        for path, text in FILES.items():
            self.write(path, text)
        self.write("docs/paper/results.json", json.dumps(RESULTS))

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def claim(self, change=None, without=(), more=()):
        """Writes claims.json: CLAIM with a change."""
        claim = {key: value for key, value in {**copy.deepcopy(CLAIM), **(change or {})}.items()
                 if key not in without}
        places = {name: f"docs/paper/results.json#{name}" for name in RESULTS}
        self.write("docs/paper/claims.json",
                   json.dumps({"results": places, "sections": [{"title": "All", "claims": [claim, *more]}]}))

    def run_script(self, *arguments):
        out, error = io.StringIO(), io.StringIO()
        with redirect_stdout(out), redirect_stderr(error):
            status = paper.main(list(arguments), self.root)
        return status, out.getvalue() + error.getvalue()

    def page(self):
        status, output = self.run_script()
        self.assertEqual(status, 0, output)
        return (self.root / "docs/paper.md").read_text()

    def assert_refused(self, rule):
        status, output = self.run_script()
        self.assertEqual(status, 1, output)
        self.assertIn(rule, output)
        self.assertFalse((self.root / "docs/paper.md").exists())


class Verdicts(House):
    def test_a_changed_result_changes_the_verdict(self):
        self.claim()
        self.assertIn("| 12.5 ms | **holds**: 12.5 is no more. |", self.page())
        self.write("docs/paper/results.json", json.dumps(RESULTS).replace("12.5", "15.25"))
        text = self.page()
        self.assertIn("| 15.2 ms | **does not hold**: 15.2 is more. |", text)
        self.assertIn("| does not hold | 1 |", text)

    def test_what_a_run_did_not_measure_cannot_be_tested(self):
        self.claim()
        for rows in ([{"row": 1, "ms": None}], []):
            self.write("out/tables.json", json.dumps({"steps": rows}))
            status, output = self.run_script("--tables", str(self.root / "out"))
            self.assertEqual(status, 0, output)
            self.assertIn("| not measured ms | **cannot be tested**: This run did not measure ms. |",
                          (self.root / "out/paper.md").read_text())
        self.assertFalse((self.root / "docs/paper.md").exists())

    def test_each_entry_of_figures_is_a_claim(self):
        self.claim({"id": "speed.{row}", "figures": [{"row": 1, "paper_ms": 14}, {"row": 1, "paper_ms": 2}],
                    "paper": "{paper_ms} ms", "results": {"ms": "steps[row={row}]/ms"}})
        self.assert_refused("claim speed.1: there are two of this id")
        self.claim({"id": "speed.{paper_ms}", "figures": [{"row": 1, "paper_ms": 14}, {"row": 1, "paper_ms": 2}],
                    "paper": "{paper_ms} ms", "results": {"ms": "steps[row={row}]/ms"}})
        text = self.page()
        self.assertIn("| 14 ms | 12.5 ms | **holds**", text)
        self.assertIn("| 2 ms | 12.5 ms | **does not hold**", text)

    def test_the_command_of_a_case_escapes_what_ends_a_name(self):
        self.claim()
        self.assertIn(r"`solver_tests 'solver: a step\, any step\, is taken'`", self.page())

    def test_a_page_that_was_edited_is_refused(self):
        self.claim()
        self.page()
        self.assertEqual(self.run_script("--check")[0], 0)
        file = self.root / "docs/paper.md"
        file.write_text(file.read_text().replace("12.5", "2.5"))
        status, output = self.run_script("--check")
        self.assertEqual(status, 1)
        self.assertIn("docs/paper.md is not what scripts/paper writes", output)


class Refusals(House):
    def test_forms(self):
        for change, without, rule in (
                ({}, ("paper",), "claim speed: has no paper"),
                ({"verdikt": []}, (), "claim speed: verdikt is no key"),
                ({"verdict": ["holds", "so"]}, (), "claim speed: needs a verdict, or `if`"),
                ({}, ("if", "then", "else"), "claim speed: needs a verdict, or `if`"),
                ({"then": ["holds"]}, (), "claim speed: then must be a pair"),
                ({"else": ["perhaps", "so"]}, (), "claim speed: 'perhaps' is no verdict; there are holds, does not hold"),
                ({}, ("command", "tests", "code"), "claim speed: 'holds' needs a command, a test or a line of code"),
                ({"ours": "{ms} ms, not 14"}, (), "has digits; figures come from results")):
            with self.subTest(rule):
                self.claim(change, without)
                self.assert_refused(rule)

    def test_paths(self):
        for path, rule in (("stepz/ms", "there is no stepz among the results"),
                           ("steps[row=1]/m", "there is no steps[row=1]/m among"),
                           ("steps[row=7]/ms", "0 rows are steps[row=7]; there must be one"),
                           ("steps[row=2]/ms", "2 rows are steps[row=2]; there must be one"),
                           ("steps[row=3]/ms", "is null; it must be a number or a text"),
                           ("steps[row=1]", "it must be a number or a text"),
                           ("steps[1]/ms", "'steps[1]' is no column or TABLE[COLUMN=VALUE]"),
                           ("steps[row=1]/ms[row=1]", "ms has no rows")):
            with self.subTest(path):
                self.claim({"results": {"ms": path}})
                self.assert_refused(f"claim speed: {path}: ")
                self.assert_refused(rule)

    def test_expressions(self):
        for change, rule in (({"if": "ms <= limit"}, "there is no figure, result or computed value limit"),
                             ({"if": "ms <="}, "is no expression"),
                             ({"if": "open('x') and ms"}, "it may hold numbers, names"),
                             ({"if": "ms.real > 0"}, "it may hold numbers, names"),
                             ({"ours": "{sm} ms"}, "there is no figure, result or computed value sm"),
                             ({"computed": {"ratio": "ms / 0"}, "if": "ratio > ms"}, "division by zero"),
                             ({"computed": {"ratio": "ms / 2"}}, "ratio is read by nothing")):
            with self.subTest(rule):
                self.claim(change)
                self.assert_refused("claim speed: ")
                self.assert_refused(rule)

    def test_what_is_named_and_not_there(self):
        for change, rule in (({"tests": ["solver: a step"]}, "there is no test case 'solver: a step'"),
                             ({"command": "walker"}, "there is no program walker"),
                             ({"command": "runner --slow"}, "runner has no option --slow"),
                             ({"command": "scripts/run"}, "there is no scripts/run"),
                             ({"command": "runner --only step"}, "runner has no option --only"),
                             ({"command": "runner 'x"}, "is no command: No closing quotation"),
                             ({"code": [["salver.h", "int"]]}, "there is no file salver.h"),
                             ({"code": [["solver.h", "int substeps = 20;"]]}, "solver.h has no 'int substeps = 20;'")):
            with self.subTest(rule):
                self.claim(change)
                self.assert_refused("claim speed: ")
                self.assert_refused(rule)

    def test_files(self):
        self.claim()
        claims = self.root / "docs/paper/claims.json"
        good = claims.read_text()
        for old, new, rule in (("results.json#steps", "no.json#steps", "no.json: there is no such file"),
                               ("#steps", "#strides", "result steps: docs/paper/results.json has no key strides"),
                               ('{"results"', '{"results', "claims.json: is no JSON"),
                               ('"sections"', '"section"', "claims.json has no sections"),
                               ('"title"', '"titel"', "section 1 has no title")):
            with self.subTest(rule):
                claims.write_text(good.replace(old, new, 1))
                self.assert_refused(rule)
        self.assertEqual(self.run_script("--tabels", "x")[0], 2)


class Figure3(unittest.TestCase):
    # Would catch a picture of colours that the library does not give any more.
    @unittest.skipUnless("PBDSURG" in os.environ, "PBDSURG names no program")
    def test_its_colours_are_what_pbdsurg_gives(self):
        recorded = json.loads((ROOT / "docs/paper/results.json").read_text())["figure3"]
        program = pathlib.Path(os.environ["PBDSURG"])
        with tempfile.TemporaryDirectory() as folder, redirect_stdout(io.StringIO()):
            self.assertEqual(load("paper-results").figure3(program.parent, pathlib.Path(folder)), recorded)

    def test_a_colouring_that_is_not_valid_is_refused(self):
        rows = json.loads((ROOT / "docs/paper/results.json").read_text())["figure3"]
        self.assertIn("<svg", paper.figure3(ROOT, rows))
        rows[0]["colors"] = [0] * 6
        with self.assertRaisesRegex(paper.Refused, "edges 0 and 1 of tet share a vertex and colour 0"):
            paper.figure3(ROOT, rows)
        rows[0]["conflicts"].pop()
        with self.assertRaisesRegex(paper.Refused, "tet has other edges or conflicts than were recorded"):
            paper.figure3(ROOT, rows)


if __name__ == "__main__":
    unittest.main()
