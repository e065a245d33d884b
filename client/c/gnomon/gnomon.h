// Gnomon for engines, in C: which lights of a scene reach what each pixel of your picture shows, ray-traced by a
// server. You rasterise the scene and shade it; the server sends one bit for each light and pixel;
// or, of lights with an extent, how many of their points it sees.
//
//   gnomon_options options = {.size = sizeof options, .server = "edge.example:7600", .pin = "sha256:...",
//                             .scene = "temple", .width = 1280, .height = 720};
//   gnomon_open(&options, &client);
//   ...each frame:
//   gnomon_look(client, &camera, NULL);
//   if (gnomon_poll(client, 0, &mask) == GNOMON_OK) ...shade with it; gnomon_mask_free it when a newer one arrives...
//
// docs/library.md walks through it, and client/c/example.c is a complete program.
//
// Threads. A client belongs to one thread at a time: calls with the same client must not overlap, but it does not
// matter which threads they come from. Clients share nothing, so different ones may be used at the same time. A mask
// never changes, so any number of threads may read the same one. Work is done inside your calls alone, and the network
// is served by gnomon_poll and gnomon_wait_open; the one thread that each client starts only looks up the server's
// name. No function blocks unless you give it a time to wait, except gnomon_free, which waits for a look-up that is
// pending. There is no global state and no signal handler.
//
// Memory. What you pass is copied before a function returns. A client and a mask are yours until you give them back to
// gnomon_free and gnomon_mask_free, in any order: masks outlive their client. Texts that a struct points to belong to
// the client, are never NULL, and last until the next gnomon_wait_open, gnomon_poll or gnomon_free with that client.
//
// Structs whose first member is `size` grow with later versions, at their end: set it to sizeof the struct before every
// call. A library that is newer than your header does not touch what your struct has no room for; one that is older
// accepts what it does not know as long as it is zero, and sets it to zero.
//
// Errors. No C++ exception leaves the library. A result below zero is an error, which gnomon_last_error describes in a
// sentence; functions that take no client fail for wrong arguments only.
#ifndef GNOMON_GNOMON_H
#define GNOMON_GNOMON_H

#include <gnomon/version.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define GNOMON_API __attribute__((visibility("default")))
#else
#define GNOMON_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct gnomon_client gnomon_client;  // a session, which is reopened if it is lost, and moves in a fleet
typedef struct gnomon_mask gnomon_mask;      // the visibility of one camera's picture

typedef enum gnomon_result {
  GNOMON_OK = 0,
  GNOMON_NOTHING = 1,        // no error: nothing has arrived in the time given
  GNOMON_BAD_ARGUMENT = -1,  // a null pointer, a wrong size, a value out of its range; the call has had no effect
  GNOMON_NOT_OPEN = -2,      // there is no session now: it is being opened, or reopened after the server was lost
  GNOMON_REFUSED = -3,       // the server refuses to serve this; see gnomon_get_refusal
  GNOMON_FAILED = -4,        // no such server, another one than expected, or it has ended the session for good
  GNOMON_CLOSED = -5,        // after gnomon_close
  GNOMON_NO_MEMORY = -6,
  GNOMON_INTERNAL = -7  // the system lacks another resource, or this library has a bug
} gnomon_result;
// GNOMON_REFUSED and those after it are final: every later call that uses the network returns the same. Free the
// client, and open another one if you like.

// What a result means, in a few words. Never NULL.
GNOMON_API const char* gnomon_result_text(gnomon_result result);

// The library's own version, as "0.1.0" and as GNOMON_VERSION_NUMBER of the header that it was built with.
GNOMON_API const char* gnomon_version(void);
GNOMON_API uint32_t gnomon_version_number(void);

// ---- Cameras

// A pinhole camera with glTF's axes: right-handed, Y up, looking along its own -Z; metres. The frustum is given by the
// tangents of its four half-angles, so that skewed ones fit too, and covers exactly the traced pixels, border included:
// the left edge of column 0 is at -tan_left, the upper edge of row 0 at tan_up. This struct will not grow.
typedef struct gnomon_camera {
  float position[3];
  float orientation[4];  // a unit quaternion x, y, z, w: from the camera's axes to the world's
  float tan_left, tan_right, tan_up, tan_down;
  float near_plane;  // metres; there is no far plane
} gnomon_camera;

// Sets the tangents, and nothing else, to those of a symmetric frustum: `vertical_fov` (radians) is that of the picture
// shown, around which lie border_x (left and right together) and border_y further pixels.
GNOMON_API gnomon_result gnomon_camera_perspective(gnomon_camera* camera, float vertical_fov, uint32_t width,
                                                   uint32_t height, uint32_t border_x, uint32_t border_y);

// ---- Opening and closing

typedef enum gnomon_transport {
  GNOMON_TRANSPORT_AUTO = 0,  // UDP while it passes, else all over the TLS connection
  GNOMON_TRANSPORT_UDP = 1,
  GNOMON_TRANSPORT_TCP = 2
} gnomon_transport;

// Which pixels say how much of their ambient light nothing near hides.
typedef enum gnomon_occlusion {
  GNOMON_OCCLUSION_NONE = 0,
  GNOMON_OCCLUSION_HALF = 1,  // those of even column and row
  GNOMON_OCCLUSION_FULL = 2   // all
} gnomon_occlusion;

// Flags of gnomon_options.
#define GNOMON_STAY_LOST 1u  // a session that is lost is not reopened: GNOMON_FAILED

// Zero or NULL selects a member's default; server, scene, width and height have none.
typedef struct gnomon_options {
  size_t size;
  const char* server;       // "HOST:PORT", "[::1]:7600"
  const char* pin;          // the server's certificate: "sha256:HEX", or a file with that in its first line
  const char* authorities;  // without a pin: a PEM file of who may have signed it; else the system's authorities
  const char* certificate;  // your own, a PEM file, for servers that accept certificates instead of tokens
  const char* key;
  const char* tenant;           // default: the server's default tenant
  const char* token;            // the tenant's secret itself
  const char* scene;            // a name that the server knows, or a file on the server where it allows that
  const char* program;          // name and version of your program, for the server's log
  const char* codec;            // "tiles_lz4", "tiles_context" or "raw32_lz4"; else the server chooses
  uint32_t width, height;       // pixels of the picture that you show
  uint32_t border_x, border_y;  // pixels to be traced around it, left and right together, top and bottom together
  float rate_hz;                // cameras a second that you intend to send; 0: as many as you get
  gnomon_transport transport;
  uint32_t flags;
  // How long the server may say nothing before its first answer; 0: 15 seconds. While it loads the scene, it says so about
  // once a second.
  uint32_t open_timeout_ms;
  // The name of the fleet of which `server` is the door, as "gnomon.example". The scene then leads to the server that has
  // it, and certificates are to be good for that name. NULL: not said.
  const char* fleet;
  // Soft shadows: how many sample points of each light that has an extent are wanted for each pixel, at most: 4 or 16; 0
  // or 1: hard shadows. Other numbers are an error.
  uint32_t samples;
  gnomon_occlusion occlusion;  // of ambient light: wanted at most
} gnomon_options;

// Begins to connect, and returns at once. On an error *client is set too, for use with gnomon_last_error and
// gnomon_free only; it is NULL if there was no memory for it.
GNOMON_API gnomon_result gnomon_open(const gnomon_options* options, gnomon_client** client);

// Serves the network until there is a session (GNOMON_OK) or `timeout_ms` has passed (GNOMON_NOTHING). A program that
// cannot wait calls gnomon_poll instead and reads gnomon_session.state.
GNOMON_API gnomon_result gnomon_wait_open(gnomon_client* client, uint32_t timeout_ms);

// Ends the session. `reason` is for the server's log, and may be NULL. The client must still be freed; what the server
// has reported can still be read.
GNOMON_API gnomon_result gnomon_close(gnomon_client* client, const char* reason);

// Closes the client, if it is not closed, and frees it. NULL is allowed.
GNOMON_API void gnomon_free(gnomon_client* client);

// Describes the error of the last call with this client that returned one; "" if none has. Valid until the next call.
GNOMON_API const char* gnomon_last_error(const gnomon_client* client);

// ---- Cameras out, masks in

// Sends the camera of this frame. `index`, which may be NULL, receives its number, counted from 0, by which its mask is
// identified. The newest camera wins: a busy server answers it and skips those that it replaced. Call it no more often than
// the session's rate_hz, if that is not 0: what comes faster is sent and mostly skipped. GNOMON_NOT_OPEN: the
// camera was not sent, as there is no session now.
GNOMON_API gnomon_result gnomon_look(gnomon_client* client, const gnomon_camera* camera, uint32_t* index);

// Serves the network, waits at most `timeout_ms` (0: not at all) for a mask newer than the last one that it gave, and
// gives the newest that has arrived. GNOMON_NOTHING: none has, and *mask is NULL. Call it once a frame even if you need
// no mask, because a session that is not served ends.
GNOMON_API gnomon_result gnomon_poll(gnomon_client* client, uint32_t timeout_ms, gnomon_mask** mask);

// ---- Masks

typedef struct gnomon_mask_view {
  size_t size;
  uint32_t index;             // of the camera
  gnomon_camera camera;       // the camera
  uint32_t width, height;     // traced pixels, border included; under load a server may trace fewer than granted
  uint32_t lights;            // number of lights
  uint32_t tiles_x, tiles_y;  // tiles of 8x8 pixels; the last of a row or column may be in part beyond the picture
  // words[light * tiles_x * tiles_y + tile_y * tiles_x + tile_x], where bit (y % 8) * 8 + x % 8, counted from the least
  // significant, is that of pixel (x, y); row 0 is the topmost. The library's memory: valid as long as the mask.
  const uint64_t* words;
  size_t word_count;
  // Numbers, tile_y * tiles_x + tile_x, of the tiles that have not arrived for some light, or of occlusion. Their words are all ones, so
  // that they cast no false shadow. Usually there are none. Valid as long as the mask.
  const uint32_t* missing_tiles;
  size_t missing_tile_count;
  uint32_t scene_time_us;   // time within the scene's animations
  uint32_t lights_version;  // of the lights that were traced
  uint32_t response_us;     // from the camera's sending to the arrival of this mask's last datagram
  uint32_t server_us;       // part of it: from the camera's arrival at the server to the mask's sending
  uint32_t gpu_us;          // part of it: rendering
  uint64_t bytes;           // of payload
  // Planes of bits in `words`: as many as lights, unless lights have several (see gnomon_mask_seen). Then
  // words[plane * tiles_x * tiles_y + ...] is how they are laid out.
  uint32_t planes;
  uint32_t samples;  // points that were traced of each light with an extent: 1, 4 or 16
  gnomon_occlusion occlusion;
  uint32_t
      occlusion_plane;  // in `words`: the first of the four that gnomon_mask_open reads, where there is occlusion
} gnomon_mask_view;

GNOMON_API gnomon_result gnomon_mask_get_view(const gnomon_mask* mask, gnomon_mask_view* view);

// 1: the light reaches what the pixel shows, or the tile is missing. 0: it does not. -1: there is no such pixel or
// light. A bit has a meaning only where the light can shine on the surface: there is one, its plane faces the light,
// and it is within range and cone. Elsewhere it may have any value; multiply it by the light's unshadowed contribution.
// Of a light with several sample points: 1 if at least half of them do.
GNOMON_API int gnomon_mask_lit(const gnomon_mask* mask, uint32_t light, uint32_t x, uint32_t y);

// How many of the light's gnomon_mask_samples points reach what the pixel shows: multiply the light's unshadowed
// contribution by their quotient. -1: there is no such pixel or light. What was said of a bit holds of this number.
GNOMON_API int gnomon_mask_seen(const gnomon_mask* mask, uint32_t light, uint32_t x, uint32_t y);

// How many points of this light were traced: 1, 4 or 16. -1: there is no such light.
GNOMON_API int gnomon_mask_samples(const gnomon_mask* mask, uint32_t light);

// The number of the light's first plane in gnomon_mask_view.words: 1 where all points are seen. With 4 or 16 points, 2 or 4
// planes follow; where the first is 0, they are the bits of the number that is seen, the most significant first. -1: there
// is no such light.
GNOMON_API int gnomon_mask_first_plane(const gnomon_mask* mask, uint32_t light);

// How many of GNOMON_OCCLUSION_SEGMENTS short segments from what the pixel shows nothing blocks: multiply its ambient
// light by their quotient. -1: the pixel has no such number of its own (take that of pixels beside it which show the same
// surface), or there is no such pixel. Where no surface is it may be any number, and
// where the tile has not arrived it is all of them.
#define GNOMON_OCCLUSION_SEGMENTS 8
GNOMON_API int gnomon_mask_open(const gnomon_mask* mask, uint32_t x, uint32_t y);

// 1: the tile of that light has arrived. 0: it has not. -1: there is no such tile or light.
GNOMON_API int gnomon_mask_has_tile(const gnomon_mask* mask, uint32_t light, uint32_t tile_x, uint32_t tile_y);

// NULL is allowed.
GNOMON_API void gnomon_mask_free(gnomon_mask* mask);

// ---- The scene

typedef struct gnomon_scene {
  size_t size;
  uint32_t revision;  // counts up whenever anything here, a light or a motion changes; 0: nothing is known yet
  const char* name;
  uint8_t content_hash[16];  // equal to your copy's if both have the same triangles: gnomond --check-scene
  uint64_t triangles;
  float bounds_min[3], bounds_max[3];
  gnomon_camera default_camera;  // a good start; its frustum is that of the traced pixels as granted
  uint32_t lights;
  uint32_t lights_version;  // of these lights, to be compared with a mask's lights_version
  uint32_t motions;
} gnomon_scene;

typedef enum gnomon_light_kind { GNOMON_POINT = 0, GNOMON_SPOT = 1, GNOMON_DIRECTIONAL = 2 } gnomon_light_kind;

// After KHR_lights_punctual of glTF, in world space. Lights that animations move are given as at scene time 0.
typedef struct gnomon_light {
  size_t size;
  gnomon_light_kind kind;
  float position[3];     // of point and spot
  float direction[3];    // the way it shines, of spot and directional: a unit vector
  float color[3];        // linear
  float intensity;       // candela; lux if directional
  float range;           // metres; 0: unlimited
  float inner_cone_cos;  // spot: full intensity inside
  float outer_cone_cos;  // spot: nothing outside
} gnomon_light;

typedef enum gnomon_motion_kind { GNOMON_SPIN = 0, GNOMON_SHIFT = 1 } gnomon_motion_kind;

// A motion that the operator assigns to nodes of the scene's file, beside its animations: protocol/WIRE.md, "Motion".
typedef struct gnomon_motion {
  size_t size;
  const char* node;
  gnomon_motion_kind kind;
  float vector[3];  // spin: the axis; shift: how far
  uint32_t period_us;
} gnomon_motion;

// The scene as the server has reported it; while a session is reopened, as it was reported last.
GNOMON_API gnomon_result gnomon_get_scene(gnomon_client* client, gnomon_scene* scene);
GNOMON_API gnomon_result gnomon_get_light(gnomon_client* client, uint32_t light, gnomon_light* out);
GNOMON_API gnomon_result gnomon_get_motion(gnomon_client* client, uint32_t motion, gnomon_motion* out);

// The light as it was traced for this mask, which may be older than the scene's.
GNOMON_API gnomon_result gnomon_mask_get_light(const gnomon_mask* mask, uint32_t light, gnomon_light* out);

// ---- The session

typedef enum gnomon_state {
  GNOMON_CONNECTING = 0,
  GNOMON_OPEN = 1,
  // It was open; it is being reopened. A server that ends says so at once; one that vanishes is given up when it has been
  // silent for its own patience, some 5 s, as its session may be resumed until then: meanwhile cameras are still sent.
  GNOMON_LOST = 2,
  GNOMON_ENDED = 3  // failed, refused or closed
} gnomon_state;

typedef struct gnomon_session {
  size_t size;
  gnomon_state state;
  uint64_t id;             // identifies the session to the server's operator
  uint32_t width, height;  // of masks from now on, border included; may be less than you asked for
  float rate_hz;           // cameras a second that are answered; 0: no limit but what the server manages
  const char* codec;
  const char* tracer;
  const char* degraded;        // why these are less than granted; "" if they are not
  uint32_t draining_ms;        // not 0: the server announced that it ends so long afterwards
  uint32_t samples;            // of each light with an extent, of masks from now on: 1, 4 or 16
  gnomon_occlusion occlusion;  // of ambient light, likewise
} gnomon_session;

GNOMON_API gnomon_result gnomon_get_session(gnomon_client* client, gnomon_session* session);

// Why a server refused: `code` is one of protocol/WIRE.md's refusal codes, 0 if none has refused; 14 also where it ended
// the session and keeps this client out for a time, which the error's text names. The other members are
// what it would have accepted, 0 if nothing of that kind is on offer.
typedef struct gnomon_refusal {
  size_t size;
  uint32_t code;
  uint32_t fit_width, fit_height;
  float fit_rate_hz;
} gnomon_refusal;

GNOMON_API gnomon_result gnomon_get_refusal(gnomon_client* client, gnomon_refusal* refusal);

typedef struct gnomon_statistics {
  size_t size;
  uint64_t cameras;        // sent
  uint64_t masks;          // that arrived complete
  uint64_t partial_masks;  // that arrived with tiles missing
  uint64_t not_given;      // of both, those that gnomon_poll did not give, as a newer one arrived first
  // Both are counted once no answer is waited for any more: 10 s after the camera, or when its session ends.
  uint64_t superseded;  // cameras without an answer while a newer one was answered
  uint64_t unanswered;  // other cameras without an answer
  uint64_t lost_slices, rebuilt_slices;
  uint64_t received_bytes;
  uint64_t reconnects;  // sessions after the first
  uint64_t resumed;     // control connections that were replaced within a session
  uint64_t in_flight;   // cameras sent since the newest that was answered
  // As the server last reported, about once a second.
  uint64_t server_frames;
  uint32_t server_queue_us, server_gpu_us, server_total_us;  // means of that second
  uint64_t moved;  // sessions that another server of the fleet took over without a gap
} gnomon_statistics;

GNOMON_API gnomon_result gnomon_get_statistics(gnomon_client* client, gnomon_statistics* statistics);

#ifdef __cplusplus
}
#endif

#endif
