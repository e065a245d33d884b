"""Shows that the operators make what they should, and that the runner tells its verdicts apart, on a made project."""
import contextlib
import io
import pathlib
import tempfile
import unittest

from mutations import Mutation, mutations_of

# A line -> what its mutants are. A blank line stands before each and behind it.
LINES = {
    "  if (a < b) f(a);": {"if (a <= b) f(a);", "if (!(a < b)) f(a);", ";"},
    "  } else if (a == b) {": {"} else if (a != b) {", "} else if (!(a == b)) {"},
    "  x = a + 9;": {"x = a - 9;", "x = a + 10;", ";"},
    "  wait += 20ms;  // 5 + 5 is said here": {"wait -= 20ms;  // 5 + 5 is said here", ";",
                                               "wait += 40ms;  // 5 + 5 is said here"},
    "  return a && !b;": {"return a || !b;", "return a && b;"},
    "  const bool so = std::max(a, 0xff) > 0.5;": {
        "const bool so = std::min(a, 0xff) > 0.5;", "const bool so = std::max(a, 0x100) > 0.5;",
        "const bool so = std::max(a, 0xff) > 1.0;", "const bool so = std::max(a, 0xff) >= 0.5;"},
    "  return true;": {"return false;"},
    "  list_.clear();": {";"},
    "  ++count_;": {"--count_;", ";"},
    "  std::vector<int> list(const Item& item);": set(),
    "  // a < b": set(),
    '  const char* text = "a + 1";': set(),
    "  assert(a < b);": set(),
    "  static_assert(kSize == 4);": set(),
    '  log::info("opened", {{"id", id + 1}});': set(),
    "#define ONE 1": set(),
    "  virtual void f() = 0;": set(),
}

MADE = {
    "CMakeLists.txt": """
cmake_minimum_required(VERSION 3.25)
project(made LANGUAGES C)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
enable_testing()
add_executable(limit_test limit.c limit_test.c)
add_test(NAME limit_test COMMAND limit_test)
""",
    "limit.c": """
int limit(int value, int most) {
  while (value > most) {
    --value;
  }
  if (0) value = 7;
  return value;
}
int nobody_tests_me(int value) { return value + 1; }
""",
    "limit_test.c": """
int limit(int value, int most);
int main() { return limit(5, 3) == 3 && limit(2, 3) == 2 ? 0 : 1; }
""",
}


class Operators(unittest.TestCase):
    def test_each_line_has_these_mutants(self):
        for line, expected in LINES.items():
            made = mutations_of("a.cpp", f"\n{line}\n")
            self.assertEqual({mutation.after.strip() for mutation in made}, expected, line)
            self.assertEqual({mutation.line for mutation in made} - {2}, set())

    def test_an_assertion_of_several_lines_is_skipped(self):
        self.assertEqual(mutations_of("a.cpp", "  assert(a &&\n         b < 1);\n"), [])

    def test_a_part_of_a_statement_is_not_deleted(self):
        made = mutations_of("a.cpp", "  const int sum = first +\n      second;\n")
        self.assertEqual([mutation.operator for mutation in made], ["arithmetic"])


class Verdicts(unittest.TestCase):
    Copy = Area = None  # those of the runner

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root, self.work = pathlib.Path(folder.name, "made"), pathlib.Path(folder.name, "work")
        self.root.mkdir()
        for file, text in MADE.items():
            (self.root / file).write_text(text)

    def copy(self):
        return self.Copy(self.root, list(MADE), self.work, [], least_s=2)

    def guards(self, copy):
        with contextlib.redirect_stdout(io.StringIO()):
            return copy.guards(self.Area(r"limit\.c", 1, ("limit_test",)))

    def test_are_told_apart(self):
        copy = self.copy()
        guards = self.guards(copy)
        lines = MADE["limit.c"].split("\n")

        def verdict(text, broken):
            number = next(i for i, line in enumerate(lines) if text in line)
            after = lines[number].replace(text, broken)
            return copy.verdict(Mutation("limit.c", number + 1, "made", lines[number], after), guards)

        self.assertEqual(verdict("value > most", "value < most"), ("killed", "limit_test: status 1"))
        self.assertEqual(verdict("--value;", ";"), ("killed", "limit_test (out of time)"))
        self.assertEqual(verdict("value + 1", "value - 1"), ("survived", ""))
        self.assertEqual(verdict("value = 7", "value = 8"), ("same", ""))
        self.assertEqual(verdict("value + 1", "valu"), ("not built", ""))
        self.assertEqual((copy.tree / "limit.c").read_text(), MADE["limit.c"], "the copy is mended again")
        self.assertEqual((self.root / "limit.c").read_text(), MADE["limit.c"], "the tree was never touched")

    def test_a_tree_whose_tests_fail_is_refused(self):
        (self.root / "limit.c").write_text(MADE["limit.c"].replace("value > most", "value < most"))
        with self.assertRaisesRegex(SystemExit, "the unbroken tree fails: limit_test"):
            self.guards(self.copy())

    def test_a_copy_follows_its_tree(self):
        copy = self.copy()
        (copy.tree / "limit.c").write_text("left by a run that was stopped")
        (copy.tree / "stale.c").write_text("")
        self.copy()
        self.assertEqual((copy.tree / "limit.c").read_text(), MADE["limit.c"])
        self.assertFalse((copy.tree / "stale.c").exists())


def run(copy, area):
    """The exit status."""
    Verdicts.Copy, Verdicts.Area = copy, area
    suite = unittest.TestSuite(map(unittest.defaultTestLoader.loadTestsFromTestCase, (Operators, Verdicts)))
    return not unittest.TextTestRunner().run(suite).wasSuccessful()
