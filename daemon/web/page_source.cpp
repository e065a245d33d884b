#include "daemon/web/page_source.h"

#include <algorithm>
#include <filesystem>

namespace gnomon::daemon::web {
namespace {

constexpr const char* kBlanks = " \t";

std::string_view line_at(std::string_view text, size_t from) {
  return text.substr(from, std::min(text.find('\n', from), text.size()) - from);
}

std::string_view trimmed(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
  return line.substr(0, line.find_last_not_of(kBlanks) + 1);
}

// How many bytes from `from`, the beginning of a line, are comment; without the last line's end. 0: the line is something
// else.
size_t comment_at(std::string_view text, size_t from) {
  const std::string_view line = line_at(text, from);
  const std::string_view words = trimmed(line);
  if (words.starts_with("//")) return line.size();
  if (!words.starts_with("/*")) return 0;
  const size_t close = text.find("*/", text.find("/*", from) + 2);
  if (close == text.npos) return 0;
  const std::string_view rest = line_at(text, close + 2);
  return trimmed(rest).empty() ? close + 2 + rest.size() - from : 0;
}

// The paths of what a module imports, as it writes them: between quotes, after `from` or `import`.
std::vector<std::string> imports_of(std::string_view module) {
  std::vector<std::string> found;
  for (const std::string_view word : {"from '", "import '"}) {
    for (size_t at = module.find(word); at != module.npos; at = module.find(word, at + 1)) {
      const size_t begin = at + word.size();
      const size_t end = module.find('\'', begin);
      if (end != module.npos && module[begin] == '.') found.emplace_back(module.substr(begin, end - begin));
    }
  }
  return found;
}

std::string with_in_head(std::string_view page, const std::string& text) {
  const size_t head = std::min(page.find("</head>"), page.size());
  return std::string(page.substr(0, head)) + text + std::string(page.substr(head));
}

}  // namespace

std::string without_comments(std::string_view module) {
  std::string left;
  for (size_t at = 0; at < module.size();) {
    if (const size_t comment = comment_at(module, at); comment > 0) {
      const std::string_view gone = module.substr(at, comment);
      left.append(static_cast<size_t>(std::count(gone.begin(), gone.end(), '\n')), '\n');
      at += comment;
    } else {
      const std::string_view line = line_at(module, at);
      left += line;
      at += line.size();
    }
    if (at < module.size()) left += module[at++];
  }
  return left;
}

std::vector<std::string> modules_of(const std::string& path, const ModuleAt& source_at) {
  std::vector<std::string> found{path};
  for (size_t i = 0; i < found.size(); ++i) {
    const auto source = source_at(found[i]);
    if (!source) {
      found.erase(found.begin() + static_cast<std::ptrdiff_t>(i--));
      continue;
    }
    for (const std::string& import : imports_of(*source)) {
      const std::string whole =
          (std::filesystem::path(found[i]).parent_path() / import).lexically_normal().generic_string();
      if (std::find(found.begin(), found.end(), whole) == found.end()) found.push_back(whole);
    }
  }
  return found;
}

std::string with_preloads(std::string_view page, const std::vector<std::string>& modules) {
  std::string links;
  for (const std::string& module : modules)
    links += "<link rel=\"modulepreload\" href=\"" + module.substr(1) + "\">\n";
  return with_in_head(page, links);
}

std::string with_script(std::string_view page, const std::string& file, std::string_view script) {
  std::string whole(page);
  const std::string reference = "<script src=\"" + file + "\"></script>";
  if (const size_t at = whole.find(reference); at != whole.npos) {
    whole.replace(at, reference.size(), "<script>" + std::string(script) + "</script>");
  }
  return whole;
}

std::string with_fleet(std::string_view page, const std::string& name) {
  return with_in_head(page, "<meta name=\"gnomon-fleet\" content=\"" + name + "\">\n");
}

}  // namespace gnomon::daemon::web
