// How gnomonctl reads its command line and says what is wrong with it. The only header here with CLI11.
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/suggestion.h"
#include "daemon/ctl/arguments.h"

namespace gnomon::ctl {

inline const CLI::Validator& is_session_id() {
  static const CLI::Validator validator(
      [](std::string& text) {
        const bool number = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
        return number ? std::string() : "'" + text + "' is no number; `gnomonctl sessions` shows the ids there are";
      },
      "ID");
  return validator;
}

// "90", "90s", "5m" or "2h" becomes a number of seconds.
inline CLI::AsNumberWithUnit seconds_with_unit() {
  const std::map<std::string, uint64_t> units{{"s", 1}, {"m", 60}, {"h", 3600}, {"d", 86400}};
  return CLI::AsNumberWithUnit(units, CLI::AsNumberWithUnit::DEFAULT, "TIME");
}

// Whether the command line has the option, and not the environment alone.
inline bool is_said(const CLI::App& app, const CLI::Option* option) {
  return std::ranges::find(app.parse_order(), option) != app.parse_order().end();
}

// A word that stands where a command should: "no command 'sessoins'; did you mean sessions?". Empty if it is not that
// which is wrong.
inline std::string unknown_command(const CLI::App& app) {
  const CLI::App* deepest = &app;
  while (!deepest->get_subcommands().empty()) deepest = deepest->get_subcommands().front();
  std::vector<std::string> known;
  for (const CLI::App* command : deepest->get_subcommands({})) known.push_back(command->get_name());
  const std::vector<std::string> left = app.remaining(true);
  if (known.empty() || left.empty()) return "";
  std::string text = "no command '" + left.front() + "'";
  if (const auto meant = suggestion(left.front(), known)) return text + "; did you mean " + *meant + "?";
  for (size_t i = 0; i < known.size(); ++i) text += (i == 0 ? "; there are: " : ", ") + known[i];
  return text;
}

// Prints what the command line asks for (help, the version) or what is wrong with it. Returns the exit status.
inline int exit_after(const CLI::App& app, const CLI::ParseError& ended) {
  const auto code = static_cast<CLI::ExitCodes>(ended.get_exit_code());
  const std::string unknown = code == CLI::ExitCodes::Success ? "" : unknown_command(app);
  if (unknown.empty()) return app.exit(ended) == 0 ? EXIT_SUCCESS : kExitUsage;
  std::fprintf(stderr, "gnomonctl: %s\n", unknown.c_str());
  return kExitUsage;
}

}  // namespace gnomon::ctl
