// Clients: opening, looking, polling, closing.
#include <gnomon/gnomon.h>

#include <cmath>

#include "client/c/convert.h"
#include "client/c/handle.h"
#include "client/c/versioned.h"
#include "client/prediction/border.h"

namespace {

using namespace gnomon;
using namespace gnomon::client::c;
using State = EngineSession::State;

bool over(const EngineSession& session) {
  return session.state() == State::failed || session.state() == State::closed;
}

// The result of a session that has ended; GNOMON_OK if it has not.
Outcome end_of(const EngineSession& session) {
  if (session.state() == State::closed) return {GNOMON_CLOSED, "the client was closed"};
  if (session.state() != State::failed) return {};
  return {session.client().refusal() ? GNOMON_REFUSED : GNOMON_FAILED, session.client().failure()->message};
}

Outcome begin(gnomon_client& client, const gnomon_options* given) {
  const auto options = read_versioned(given);
  if (!options) {
    return bad_argument(
        "gnomon_options is NULL, its size is not sizeof gnomon_options, or it says what only a later "
        "version of the library knows");
  }
  auto made = to_options(*options);
  if (!made) return bad_argument(made.error().message);
  client.session = std::make_unique<EngineSession>(std::move(*made));
  return {};
}

Outcome wait_open(EngineSession& session, uint32_t timeout_ms) {
  const auto settled = [&] { return session.client().online() || over(session); };
  if (!settled()) session.serve(timeout_ms, settled);
  if (session.state() == State::open) return {};
  Outcome end = end_of(session);
  return end.result == GNOMON_OK ? Outcome{GNOMON_NOTHING} : end;
}

Outcome look(EngineSession& session, const gnomon_camera* camera, uint32_t* index) {
  if (!camera) return bad_argument("camera is NULL");
  const protocol::CameraView view = to_camera(*camera);
  if (!protocol::is_valid(view)) {
    return bad_argument(
        "camera: a number is not finite, the orientation's length is not 1, the frustum is empty or "
        "the near plane is not in front");
  }
  if (Outcome end = end_of(session); end.result != GNOMON_OK) return end;
  if (session.state() != State::open) return {GNOMON_NOT_OPEN, "there is no session at this moment"};
  const uint32_t number = session.look(view);
  if (index) *index = number;
  return {};
}

Outcome poll(EngineSession& session, uint32_t timeout_ms, gnomon_mask** mask) {
  if (!mask) return bad_argument("mask is NULL");
  *mask = nullptr;
  if (Outcome end = end_of(session); end.result == GNOMON_CLOSED) return end;
  session.serve(0, {});  // takes in what has already arrived, so that next() gives the newest
  auto newest = session.next();
  if (!newest && timeout_ms > 0) {
    session.serve(timeout_ms, [&] {
      newest = session.next();
      return newest || over(session);
    });
  }
  if (newest) {
    *mask = new gnomon_mask{newest, newest->mask.missing_tiles()};
    return {};
  }
  Outcome end = end_of(session);
  return end.result == GNOMON_OK ? Outcome{GNOMON_NOTHING} : end;
}

}  // namespace

extern "C" {

const char* gnomon_result_text(gnomon_result result) {
  switch (result) {
    case GNOMON_OK: return "it worked";
    case GNOMON_NOTHING: return "nothing has come in time";
    case GNOMON_BAD_ARGUMENT: return "an argument is wrong";
    case GNOMON_NOT_OPEN: return "there is no session at this moment";
    case GNOMON_REFUSED: return "the server refuses this";
    case GNOMON_FAILED: return "the server cannot be reached, is another one, or has ended the session";
    case GNOMON_CLOSED: return "the client was closed";
    case GNOMON_NO_MEMORY: return "there is not enough memory";
    case GNOMON_INTERNAL: return "something failed inside the library";
  }
  return "no result of this version";
}

const char* gnomon_version(void) { return GNOMON_VERSION_TEXT; }

uint32_t gnomon_version_number(void) { return GNOMON_VERSION_NUMBER; }

gnomon_result gnomon_camera_perspective(gnomon_camera* camera, float vertical_fov, uint32_t width, uint32_t height,
                                        uint32_t border_x, uint32_t border_y) {
  const bool opens = vertical_fov > 0 && vertical_fov < static_cast<float>(M_PI);
  if (!camera || !opens || width == 0 || height == 0) return GNOMON_BAD_ARGUMENT;
  scenes::CameraPose pose;
  pose.vertical_fov = vertical_fov;
  const auto view = client::view_of(pose, {width, height, border_x, border_y});
  camera->tan_left = view.tan_left;
  camera->tan_right = view.tan_right;
  camera->tan_up = view.tan_up;
  camera->tan_down = view.tan_down;
  return GNOMON_OK;
}

gnomon_result gnomon_open(const gnomon_options* options, gnomon_client** client) {
  if (!client) return GNOMON_BAD_ARGUMENT;
  *client = new (std::nothrow) gnomon_client;
  if (!*client) return GNOMON_NO_MEMORY;
  const gnomon_result begun = guarded(*client, [&](gnomon_client& made) { return begin(made, options); });
  if (begun != GNOMON_OK) (*client)->broken = begun;
  return begun;
}

gnomon_result gnomon_wait_open(gnomon_client* client, uint32_t timeout_ms) {
  return guarded(client, [&](gnomon_client& open) { return wait_open(*open.session, timeout_ms); });
}

gnomon_result gnomon_look(gnomon_client* client, const gnomon_camera* camera, uint32_t* index) {
  return guarded(client, [&](gnomon_client& open) { return look(*open.session, camera, index); });
}

gnomon_result gnomon_poll(gnomon_client* client, uint32_t timeout_ms, gnomon_mask** mask) {
  if (mask) *mask = nullptr;
  return guarded(client, [&](gnomon_client& open) { return poll(*open.session, timeout_ms, mask); });
}

gnomon_result gnomon_close(gnomon_client* client, const char* reason) {
  return guarded(client, [&](gnomon_client& open) {
    open.session->close(reason ? reason : "");
    return Outcome{};
  });
}

void gnomon_free(gnomon_client* client) {
  if (!client) return;
  guarded(client, [](gnomon_client& open) {
    if (open.session->state() != State::closed) open.session->close("");
    return Outcome{};
  });
  delete client;
}

const char* gnomon_last_error(const gnomon_client* client) {
  return client ? client->error.data() : "there is no client";
}

}  // extern "C"
