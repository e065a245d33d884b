// A complete client on one screen: connects, looks through a camera every frame and draws what is to be shown.
//   gnomon-example HOST:PORT SCENE PIN [PICTURE.png]   PIN: the server's certificate, as gnomond's ready line names it
//
// The server traces 64x36 pixels more than are shown. Masks take a while to arrive; until then frames are predicted
// from older ones, four ahead. An engine has a renderer of its own, which does with a Showing what ClientRenderer does.
#include <cstdio>

#include "client/media/scene_file.h"
#include "client/view/client_renderer.h"

using namespace gnomon;
using namespace std::chrono_literals;

namespace {

int fail(const Error& error) { return std::fprintf(stderr, "%s\n", error.message.c_str()), 1; }

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) return std::fprintf(stderr, "usage: gnomon-example HOST:PORT SCENE PIN [PICTURE.png]\n"), 2;
  const auto server = client::parse_address(argv[1]);
  if (!server) return fail(server.error());
  const client::ViewSize size{.width = 320, .height = 180, .border_x = 64, .border_y = 36};

  client::ThinClientOptions options;
  options.mode = client::Mode::predicted;
  options.ahead = 4;
  options.stream.connect.server = *server;
  options.stream.connect.trust.pin = argv[3];
  protocol::Hello& hello = options.stream.connect.hello;
  hello.client = "gnomon-example";
  hello.scene = argv[2];
  hello.width = static_cast<uint16_t>(size.traced_width());
  hello.height = static_cast<uint16_t>(size.traced_height());
  hello.border_x = static_cast<uint16_t>(size.border_x);
  hello.border_y = static_cast<uint16_t>(size.border_y);

  client::Loop loop;
  client::ThinClient thin_client(loop, std::move(options));
  if (const auto opened = thin_client.wait_open(); !opened) return fail(opened.error());

  // The same scene on this side: both rasterise the same triangles.
  const auto scene = client::load_own_scene(argv[2], {}, thin_client.welcome().motions);
  if (!scene) return fail(scene.error());
  if (const auto same = client::check_same_scene(**scene, thin_client.scene()); !same) return fail(same.error());
  auto view = client::ClientRenderer::create(*scene, size, {});
  if (!view) return fail(view.error());

  // The engine's own loop. The scene's rest camera stands for the player's.
  scenes::CameraPose pose = scenes::orbit_pose(**scene, 0);
  client::Picture picture;
  for (int frame = 0; frame < 60 && !thin_client.failure(); ++frame) {
    pose.position.x += 0.005f;
    thin_client.look(client::view_of(pose, size));
    loop.run_until(Clock::now() + 16ms, [] { return false; });  // or loop.poll() beside the engine's own waiting
    const auto showing = thin_client.next();
    if (!showing) continue;  // no masks have arrived yet, or nothing has changed
    auto drawn = view->shade(*showing);
    if (!drawn) return fail(drawn.error());
    picture = std::move(*drawn);
    std::printf("camera %u with the masks of %u, %zu tiles missing, %.1f ms after the camera\n", showing->index,
                showing->seen->index, showing->seen->mask.missing_tiles().size(), to_milliseconds(showing->age));
  }
  if (thin_client.failure()) return fail(*thin_client.failure());
  thin_client.close("done");
  if (argc < 5 || picture.width == 0) return 0;
  const auto written = client::write_png(argv[4], picture);
  return written ? 0 : fail(written.error());
}
