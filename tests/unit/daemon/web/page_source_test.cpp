// What browsers get of a module and of the page.
#include "daemon/web/page_source.h"

#include <gtest/gtest.h>

#include <map>

namespace gnomon::daemon::web {
namespace {

TEST(PageSource, LosesLinesOfCommentAndNoOther) {
  const std::string module =
      "// A sentence.\n"
      "import { a } from './a.js'; // stays\n"
      "/**\n"
      " * @param {string} b 'quoted' and // more\n"
      " */\n"
      "const url = 'https://host/';\n"
      "  /** @type {number} */ let c = 1;\n"
      "  /* alone */\n"
      "const d = `\n"
      "  // of a shader\n"
      "  x /* y */;`;\n"
      "/** never closed\n"
      "last";
  EXPECT_EQ(without_comments(module),
            "\n"
            "import { a } from './a.js'; // stays\n"
            "\n\n\n"
            "const url = 'https://host/';\n"
            "  /** @type {number} */ let c = 1;\n"
            "\n"
            "const d = `\n"
            "\n"
            "  x /* y */;`;\n"
            "/** never closed\n"
            "last");
  EXPECT_EQ(without_comments(""), "");
  EXPECT_EQ(without_comments("// at the end"), "");
}

TEST(PageSource, FindsWhatAModuleImports) {
  const std::map<std::string, std::string> files = {
      {"/app.js", "import { a } from './ui/a.js';\nimport {\n  b,\n} from './b.js';\nimport './gone.js';\n"},
      {"/ui/a.js",
       "export { c } from '../b.js';\nconst later = import('./later.js');\nimport node from 'node:fs';\n"},
      {"/b.js", "import { a } from './ui/a.js';\n"},  // in a circle
      {"/later.js", ""},
      {"/alone.js", ""}};
  const ModuleAt source_at = [&](const std::string& path) {
    const auto found = files.find(path);
    return found == files.end() ? std::nullopt : std::optional<std::string_view>(found->second);
  };
  EXPECT_EQ(modules_of("/app.js", source_at), (std::vector<std::string>{"/app.js", "/ui/a.js", "/b.js"}));
  EXPECT_TRUE(modules_of("/gone.js", source_at).empty());
}

TEST(PageSource, NamesModulesInTheHead) {
  EXPECT_EQ(with_preloads("<head>\n</head><body>", {"/app.js", "/ui/a.js"}),
            "<head>\n<link rel=\"modulepreload\" href=\"app.js\">\n<link rel=\"modulepreload\" href=\"ui/a.js\">\n"
            "</head><body>");
}

TEST(PageSource, HasItsScriptInIt) {
  EXPECT_EQ(with_script("<body><script src=\"start.js\"></script>\n</body>", "start.js", "a(1);\n"),
            "<body><script>a(1);\n</script>\n</body>");
  EXPECT_EQ(with_script("<body></body>", "start.js", "a(1);"), "<body></body>");
}

TEST(PageSource, SaysOfWhichFleetItsServerIs) {
  EXPECT_EQ(with_fleet("<head>\n</head><body>", "gnomon.example"),
            "<head>\n<meta name=\"gnomon-fleet\" content=\"gnomon.example\">\n</head><body>");
}

}  // namespace
}  // namespace gnomon::daemon::web
