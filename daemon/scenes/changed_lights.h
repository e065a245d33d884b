// What operators have changed of the lights of scenes, as it stands in a file and as nodes of a fleet tell each other.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "daemon/render/light_change.h"

namespace gnomon::daemon {

// {"lights": [{"scene": "temple", "light": 0, "at_ms": 1764000000000, "change": {"on": false}}]}. `change` is what differs
// from the scene's file, so that {} says that a light was changed back.
class ChangedLights {
 public:
  struct Light {
    int64_t at_ms = 0;   // since 1970, by the clock of whoever changed it last
    LightChange change;  // of the light as it is in its file
  };
  using Place = std::pair<std::string, uint32_t>;  // the scene's name, and the light's number in it

  static constexpr size_t kMost = 65'536;
  static constexpr uint32_t kMostNumber = 9'999;

  // The error says what is wrong with the text.
  static Result<ChangedLights> parse(const std::string& text);
  // None where there is no such file. The error names the file.
  static Result<ChangedLights> read(const std::filesystem::path& file);

  std::string text() const;
  // The file is replaced when it is complete. The error names it.
  Result<void> write(const std::filesystem::path& file) const;

  // Adds a change. It is newer than what is known of the light, also if the clock by which `at_ms` is was behind. Error if
  // there are too many.
  Result<void> add(const Place& place, const LightChange& change, int64_t at_ms);
  // Takes over what is newer in `other`, and returns the places of it.
  std::vector<Place> take(const ChangedLights& other);

  const std::map<Place, Light>& lights() const { return lights_; }
  // `lights`, those of the scene's file, as they are with the changes. What does not fit them is left out.
  std::vector<scenes::Light> applied(const std::string& scene, std::vector<scenes::Light> lights) const;

 private:
  std::map<Place, Light> lights_;
};

}  // namespace gnomon::daemon
