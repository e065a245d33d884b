#include "daemon/ctl/scene_load.h"

#include <cmath>
#include <future>
#include <map>

#include "common/printable.h"
#include "common/progress.h"
#include "daemon/ctl/table.h"

namespace gnomon::ctl {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto kBetweenLooks = 300ms;

// The member `name` of a list of objects; nullptr if there is none.
const json* named(const json& status, const char* key, const std::string& name) {
  const auto list = status.find(key);
  if (list == status.end() || !list->is_array()) return nullptr;
  for (const json& each : *list) {
    if (each.value("name", std::string()) == name) return &each;
  }
  return nullptr;
}

}  // namespace

std::string stage_line(const json& status, const std::string& name) {
  static const std::map<std::string, std::string> kWords = {
      {"queued", "waits for others to be read"}, {"reading", "is being read"}, {"preparing", "is being prepared"}};
  const json* const scene = named(status, "scenes_under_way", name);
  if (!scene) return "";
  const auto words = kWords.find(scene->value("stage", std::string()));
  std::string line = without_controls(name) + " " + (words == kWords.end() ? "is on its way" : words->second);
  if (scene->contains("share")) line += ", " + fixed(std::floor(100 * scene->value("share", 0.0)), 0) + "%";
  return line + ", " + fixed(scene->value("seconds", 0.0), 0) + " s";
}

Result<std::string> load_scene(AdminClient& admin, const std::string& name) {
  auto answer = std::async(std::launch::async, [&] { return admin.post("/scenes/" + name + "/load"); });
  Progress progress;
  while (answer.wait_for(kBetweenLooks) != std::future_status::ready) {
    const TimePoint now = Clock::now();
    if (!progress.due(now)) continue;
    const auto status = admin.status();
    const std::string line = status ? stage_line(*status, name) : "";
    if (!line.empty()) progress.show(line, now);
  }
  progress.clear();
  return answer.get();
}

}  // namespace gnomon::ctl
