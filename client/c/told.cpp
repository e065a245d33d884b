// What the server has reported: the scene, the session, and figures.
#include <gnomon/gnomon.h>

#include <algorithm>

#include "client/c/convert.h"
#include "client/c/handle.h"
#include "client/c/versioned.h"

namespace {

using namespace gnomon;
using namespace gnomon::client::c;

gnomon_state state_of(EngineSession::State state) {
  switch (state) {
    case EngineSession::State::connecting: return GNOMON_CONNECTING;
    case EngineSession::State::open: return GNOMON_OPEN;
    case EngineSession::State::lost: return GNOMON_LOST;
    case EngineSession::State::failed:
    case EngineSession::State::closed: break;
  }
  return GNOMON_ENDED;
}

gnomon_scene scene_of(const ServerState& told) {
  gnomon_scene scene{};
  scene.revision = told.revision;
  scene.name = told.scene.name.c_str();
  std::copy(told.scene.content_hash.begin(), told.scene.content_hash.end(), scene.content_hash);
  scene.triangles = told.scene.triangles;
  std::copy(told.scene.bounds_min.begin(), told.scene.bounds_min.end(), scene.bounds_min);
  std::copy(told.scene.bounds_max.begin(), told.scene.bounds_max.end(), scene.bounds_max);
  scene.default_camera = to_c(told.scene.default_camera);
  scene.lights = static_cast<uint32_t>(told.scene.lights.size());
  scene.lights_version = told.lights_version;
  scene.motions = static_cast<uint32_t>(told.welcome.motions.size());
  return scene;
}

gnomon_session session_of(const EngineSession& session) {
  const ServerState& told = session.server();
  gnomon_session out{};
  out.state = state_of(session.state());
  out.id = told.welcome.session.value;
  out.width = told.width;
  out.height = told.height;
  out.rate_hz = told.rate_hz;
  out.codec = told.revision > 0 ? protocol::to_string(told.welcome.codec) : "";
  out.tracer = told.welcome.tracer.c_str();
  out.degraded = told.degraded.c_str();
  out.draining_ms = told.draining_ms;
  out.samples = told.samples.per_light;
  out.occlusion = static_cast<gnomon_occlusion>(told.samples.occlusion);
  return out;
}

gnomon_statistics statistics_of(const EngineSession& session) {
  const client::StreamCounters counted = session.client().counters();
  const protocol::Stats& server = session.server().stats;
  gnomon_statistics out{};
  out.cameras = counted.asked;
  out.masks = counted.complete;
  out.partial_masks = counted.incomplete;
  out.not_given = counted.complete + counted.incomplete - session.given();
  out.superseded = counted.superseded;
  out.unanswered = counted.unanswered;
  out.lost_slices = counted.lost_slices;
  out.rebuilt_slices = counted.rebuilt_slices;
  out.received_bytes = session.client().received_bytes();
  out.reconnects = session.client().reconnects();
  out.resumed = counted.resumed;
  out.in_flight = session.client().in_flight();
  out.server_frames = server.frames;
  out.server_queue_us = server.queue_us;
  out.server_gpu_us = server.gpu_us;
  out.server_total_us = server.total_us;
  out.moved = counted.moved;
  return out;
}

Outcome written(bool done, const char* what) { return done ? Outcome{} : wrong_size(what); }

}  // namespace

extern "C" {

gnomon_result gnomon_get_scene(gnomon_client* client, gnomon_scene* scene) {
  return guarded(client, [&](gnomon_client& open) {
    return written(write_versioned(scene_of(open.session->server()), scene), "gnomon_scene");
  });
}

gnomon_result gnomon_get_light(gnomon_client* client, uint32_t light, gnomon_light* out) {
  return guarded(client, [&](gnomon_client& open) {
    const auto& lights = open.session->server().scene.lights;
    if (light >= lights.size()) return bad_argument("the scene has " + std::to_string(lights.size()) + " lights");
    return written(write_versioned(to_c(lights[light]), out), "gnomon_light");
  });
}

gnomon_result gnomon_get_motion(gnomon_client* client, uint32_t motion, gnomon_motion* out) {
  return guarded(client, [&](gnomon_client& open) {
    const auto& motions = open.session->server().welcome.motions;
    if (motion >= motions.size())
      return bad_argument("the scene has " + std::to_string(motions.size()) + " motions");
    return written(write_versioned(to_c(motions[motion]), out), "gnomon_motion");
  });
}

gnomon_result gnomon_get_session(gnomon_client* client, gnomon_session* session) {
  return guarded(client, [&](gnomon_client& open) {
    return written(write_versioned(session_of(*open.session), session), "gnomon_session");
  });
}

gnomon_result gnomon_get_refusal(gnomon_client* client, gnomon_refusal* refusal) {
  return guarded(client, [&](gnomon_client& open) {
    gnomon_refusal out{};
    if (const auto& refused = open.session->client().refusal()) {
      out.code = static_cast<uint32_t>(refused->code);
      out.fit_width = refused->fit_width;
      out.fit_height = refused->fit_height;
      out.fit_rate_hz = refused->fit_rate_hz;
    }
    return written(write_versioned(out, refusal), "gnomon_refusal");
  });
}

gnomon_result gnomon_get_statistics(gnomon_client* client, gnomon_statistics* statistics) {
  return guarded(client, [&](gnomon_client& open) {
    return written(write_versioned(statistics_of(*open.session), statistics), "gnomon_statistics");
  });
}

}  // extern "C"
