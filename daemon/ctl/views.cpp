#include "daemon/ctl/views.h"

#include <algorithm>

#include "daemon/ctl/status_members.h"
#include "daemon/ctl/table.h"

namespace gnomon::ctl {
namespace {

using nlohmann::json;

// The certificate that expires first; empty if the daemon does not say.
std::string certificate_line(const json& status) {
  const auto certificate = status.find("certificate");
  if (certificate == status.end() || !certificate->is_object()) return "";
  const double days = number(*certificate, "days_left");
  const std::string left = days < 0 ? "has EXPIRED: clients refuse it" : "expires in " + fixed(days, 0) + " days";
  return text(*certificate, "key") + " " + left + "\n";
}

// What the audit log's file did not take; empty if it took everything.
std::string audit_line(const json& status) {
  const auto audit = status.find("audit");
  if (audit == status.end() || !audit->is_object() || number(*audit, "unwritten") == 0) return "";
  const std::string why = text(*audit, "why");
  const std::string lines = whole(*audit, "unwritten");
  return (why.empty() ? "audit log: " : "audit log NOT WRITTEN: " + why + "; ") + lines +
         (lines == "1" ? " line" : " lines") + " not in the file, but in the daemon's log\n";
}

}  // namespace

std::string status_text(const json& status) {
  std::string out = "gnomond " + text(status, "version") + ": " + state_of(status) + ", policy " +
                    text(status, "policy") + ", " + std::to_string(list(status, "sessions").size()) +
                    " sessions, Jain index " + fixed(number(status, "jain"), 3) + "\n";
  if (const std::string why = text(status, "why_not_ready"); !why.empty()) out += "not ready: " + why + "\n";
  out += certificate_line(status) + audit_line(status);
  int device_number = 0;
  for (const json& device : list(status, "devices")) {
    out += "device " + std::to_string(device_number++) + ": " + text(device, "name") + " (" +
           text(device, "driver") + "), tracer " + text(device, "tracer") + ", raster " + text(device, "raster") +
           ": " + (device.value("up", false) ? "up" : "down") +
           (device.value("drained", false) ? ", drained" : "") + ", " +
           std::to_string(device.value("sessions", 0)) + " sessions\n";
  }
  Table tenants({"TENANT", ">WEIGHT", ">SESSIONS", ">SHARE", ">BY WEIGHT", ">GPU s"});
  for (const json& tenant : list(status, "tenants")) {
    tenants.add({text(tenant, "name"), whole(tenant, "weight"), whole(tenant, "sessions"),
                 percent(number(tenant, "share")), percent(number(tenant, "expected_share")),
                 fixed(number(tenant, "gpu_seconds"), 1)});
  }
  return out + "\n" + scenes_text(status) + "\n" + tenants.text();
}

// How far the build of a scene's light buffers is, and at which light.
std::string light_buffers_of(const json& scene) {
  const auto found = scene.find("light_buffers");
  if (found == scene.end()) return "";
  const std::string state = text(*found, "state");
  if (state != "building") return state;
  const json& lights = list(*found, "lights_percent");
  const auto done = std::count_if(lights.begin(), lights.end(), [](const json& share) { return share >= 100; });
  const size_t at = std::min(static_cast<size_t>(done) + 1, lights.size());
  return fixed(number(*found, "percent"), 0) + "%, light " + std::to_string(at) + " of " +
         std::to_string(lights.size());
}

std::string scenes_text(const json& status) {
  Table table({"SCENE", ">TRIANGLES", ">LIGHTS", ">SESSIONS", ">HOST MiB", ">DEVICE MiB", ">LOAD s", ">BUILD s",
               "LIGHT BUFFERS"});
  for (const json& scene : list(status, "scenes")) {
    table.add({text(scene, "name"), whole(scene, "triangles"), whole(scene, "lights"), whole(scene, "sessions"),
               mebibytes(number(scene, "memory_bytes")), mebibytes(number(scene, "device_memory_bytes")),
               fixed(number(scene, "load_seconds"), 2), fixed(number(scene, "tracer_build_seconds"), 2),
               light_buffers_of(scene)});
  }
  return table.text();
}

namespace {

// What a session gets at present where that is less than what it was granted, as "480x272 7.5 Hz 4 points".
std::string served_of(const json& session) {
  const auto found = session.find("served");
  if (found == session.end() || !found->is_object()) return "";
  const json& served = *found;
  const auto differs = [&](const char* key) { return number(served, key) != number(session, key); };
  std::string words;
  const auto say = [&](const std::string& word) { words += (words.empty() ? "" : " ") + word; };
  if (differs("width") || differs("height")) say(size_of(served));
  if (differs("rate_hz")) say(fixed(number(served, "rate_hz"), 1) + " Hz");
  if (differs("samples")) say(whole(served, "samples") + (number(served, "samples") == 1 ? " point" : " points"));
  if (text(served, "occlusion") != text(session, "occlusion")) say("occlusion " + text(served, "occlusion"));
  if (number(served, "untraced_lights") > 0) say("without " + whole(served, "untraced_lights") + " lights");
  return words.empty() ? "as granted" : words;
}

}  // namespace

std::string sessions_text(const json& status) {
  Table table({"SESSION", "TENANT", "SCENE", ">SIZE", "SERVED", "TRANSPORT", "ADDRESS", ">FRAMES", ">COALESCED",
               ">QUEUE ms", ">GPU ms", ">TOTAL ms"});
  for (const json& s : list(status, "sessions")) {
    table.add({text(s, "id"), text(s, "tenant"), text(s, "scene"), size_of(s), served_of(s), text(s, "transport"),
               text(s, "address"), whole(s, "frames"), whole(s, "coalesced"),
               fixed(number(s, "queue_us") / 1000, 1), fixed(number(s, "gpu_us") / 1000, 1),
               fixed(number(s, "total_us") / 1000, 1)});
  }
  return table.text();
}

}  // namespace gnomon::ctl
