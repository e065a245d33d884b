// What the build embeds, as browsers get it: shorter, and with all modules named at once. Pure.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon::daemon::web {

// A module without the lines that are comment alone (`// ...`, and `/* ... */` from the beginning of a line to the end of
// one). The numbers of lines stay, so that what a browser's console says is found in the source.
std::string without_comments(std::string_view module);

// The source of the module at a path ("/link/way.js"); nothing if there is none.
using ModuleAt = std::function<std::optional<std::string_view>(const std::string& path)>;

// The paths of a module and of all that it imports statically, directly or not; each once, in the order of their finding.
// What it names that is not there is left out. Comments that look like imports count as such: give it none.
std::vector<std::string> modules_of(const std::string& path, const ModuleAt& source_at);

// A page whose head names these modules, so that a browser asks for all of them at once: otherwise it finds each only when
// the one that imports it has come.
std::string with_preloads(std::string_view page, const std::vector<std::string>& modules);

// A page that has a script in it in place of a reference to it (`<script src="start.js"></script>`), so that none comes
// without the other.
std::string with_script(std::string_view page, const std::string& file, std::string_view script);

// A page whose head says of which fleet its server is. Precondition: the name has nothing that HTML would take for its own.
std::string with_fleet(std::string_view page, const std::string& name);

}  // namespace gnomon::daemon::web
