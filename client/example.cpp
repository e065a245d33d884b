// A whole client in one screen: connect, ask for a camera each frame, use the visibility of the newest answer.
//   gnomon-example HOST:PORT SCENE PIN      PIN: the server's certificate, as gnomond's ready line names it
#include <cstdio>

#include "client/visibility_stream.h"

using namespace gnomon;
using namespace std::chrono_literals;

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: gnomon-example HOST:PORT SCENE PIN\n"), 2;
  const auto server = client::parse_address(argv[1]);
  if (!server) return std::fprintf(stderr, "%s\n", server.error().message.c_str()), 2;

  protocol::Hello hello;
  hello.client = "gnomon-example";
  hello.scene = argv[2];
  hello.width = 320;
  hello.height = 180;

  client::Loop loop;
  client::VisibilityStream stream(
      loop, {.connect = {.server = *server, .trust = {.pin = argv[3]}, .hello = hello}},
      {.answer = [](const client::Answer& answer) {
        const TileMaskView mask = answer.mask.mask();  // one bit for each light and pixel: shade with it here
        const bool lit = mask.lit(mask.grid.width / 2, mask.grid.height / 2, 0);
        std::printf("frame %u: light 0 %s the middle, %zu tiles missing, %.1f ms\n", answer.mask.frame.value,
                    lit ? "sees" : "does not see", answer.mask.missing_tiles().size(),
                    to_milliseconds(answer.response));
      }});
  if (const auto opened = stream.wait_open(); !opened) {
    return std::fprintf(stderr, "%s\n", opened.error().message.c_str()), 1;
  }

  // The engine's own loop. The manifest's camera stands for the player's; it must cover the asked size.
  protocol::CameraView camera = stream.scene().default_camera;
  for (int frame = 0; frame < 60 && !stream.connection().failure(); ++frame) {
    camera.position[0] += 0.005f;
    stream.ask(camera);
    loop.run_until(Clock::now() + 16ms, [] { return false; });  // or loop.poll() beside the engine's own waiting
  }
  if (const auto& failure = stream.connection().failure()) {
    return std::fprintf(stderr, "%s\n", failure->message.c_str()), 1;
  }
  stream.close("done");
}
