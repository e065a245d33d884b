// A complete client in C: connects, turns the scene's own camera a few steps and prints, for each, how many pixels each
// light reaches and how long the answer took; writes the first light's last mask as a picture.
//
//   cc -std=c99 example.c $(pkg-config --cflags --libs gnomon) -lm -o example
//   ./example HOST:PORT PIN SCENE WIDTHxHEIGHT STEPS [PICTURE.pgm]
//
// An engine differs in one thing: it does not wait for masks, but calls gnomon_look and gnomon_poll(client, 0, ...)
// once a frame, and shades with the newest mask that it has.
#include <gnomon/gnomon.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define WAIT_MS 60000  // a server may build a scene's acceleration structures before its first answer
#define STEP_RADIANS 0.05

static int fail(const char* what, gnomon_result result, const gnomon_client* client) {
  fprintf(stderr, "%s: %s: %s\n", what, gnomon_result_text(result), gnomon_last_error(client));
  return 1;
}

// The camera, turned about the world's vertical axis: the product of that rotation and its own.
static gnomon_camera turned(gnomon_camera camera, double angle) {
  const double s = sin(angle / 2), c = cos(angle / 2);
  const double x = camera.orientation[0], y = camera.orientation[1];
  const double z = camera.orientation[2], w = camera.orientation[3];
  camera.orientation[0] = (float)(c * x + s * z);
  camera.orientation[1] = (float)(c * y + s * w);
  camera.orientation[2] = (float)(c * z - s * x);
  camera.orientation[3] = (float)(c * w - s * y);
  return camera;
}

// Sends a camera and waits for its own mask.
static gnomon_result mask_of(gnomon_client* client, const gnomon_camera* camera, gnomon_mask** mask) {
  uint32_t index;
  gnomon_result result = gnomon_look(client, camera, &index);
  while (result == GNOMON_OK) {
    gnomon_mask_view view = {.size = sizeof view};
    result = gnomon_poll(client, WAIT_MS, mask);
    if (result != GNOMON_OK) break;
    result = gnomon_mask_get_view(*mask, &view);
    // Passes over late masks of earlier cameras, and over masks with missing tiles, which would count as lit.
    if (view.index == index && view.missing_tile_count == 0) break;
    gnomon_mask_free(*mask);
    if (view.index == index) result = gnomon_look(client, camera, &index);
  }
  return result;
}

static void print_lit(uint32_t step, const gnomon_mask* mask, const gnomon_mask_view* view) {
  printf("camera %u: %.1f ms, lit", step, view->response_us / 1000.0);
  for (uint32_t light = 0; light < view->lights; ++light) {
    uint32_t lit = 0;
    for (uint32_t y = 0; y < view->height; ++y) {
      for (uint32_t x = 0; x < view->width; ++x) lit += gnomon_mask_lit(mask, light, x, y) == 1;
    }
    printf(" %u", lit);
  }
  printf(" of %u pixels\n", view->width * view->height);
}

// Writes white where the first light reaches. PGM is text, then a byte for each pixel, row by row from the top.
static int write_picture(const char* path, const gnomon_mask* mask, const gnomon_mask_view* view) {
  FILE* file = fopen(path, "wb");
  if (!file) return perror(path), 1;
  fprintf(file, "P5\n%u %u\n255\n", view->width, view->height);
  for (uint32_t y = 0; y < view->height; ++y) {
    for (uint32_t x = 0; x < view->width; ++x) putc(gnomon_mask_lit(mask, 0, x, y) == 1 ? 255 : 0, file);
  }
  return fclose(file) == 0 ? 0 : (perror(path), 1);
}

static int fly(gnomon_client* client, uint32_t steps, const char* picture) {
  gnomon_scene scene = {.size = sizeof scene};
  gnomon_get_scene(client, &scene);
  printf("scene %s, %u lights, hash ", scene.name, scene.lights);
  for (size_t i = 0; i < sizeof scene.content_hash; ++i) printf("%02x", scene.content_hash[i]);
  printf("\n");
  for (uint32_t step = 0; step < steps; ++step) {
    const gnomon_camera camera = turned(scene.default_camera, step * STEP_RADIANS);
    gnomon_mask* mask;
    gnomon_mask_view view = {.size = sizeof view};
    const gnomon_result result = mask_of(client, &camera, &mask);
    if (result != GNOMON_OK) return fail("no mask", result, client);
    gnomon_mask_get_view(mask, &view);
    print_lit(step, mask, &view);
    const int failed = picture && step + 1 == steps ? write_picture(picture, mask, &view) : 0;
    gnomon_mask_free(mask);
    if (failed) return failed;
  }
  return 0;
}

int main(int argc, char** argv) {
  gnomon_options options = {.size = sizeof options};
  gnomon_client* client;
  if (argc < 6 || sscanf(argv[4], "%ux%u", &options.width, &options.height) != 2) {
    fprintf(stderr, "usage: %s HOST:PORT PIN SCENE WIDTHxHEIGHT STEPS [PICTURE.pgm]\n", argv[0]);
    return 2;
  }
  options.server = argv[1];
  options.pin = argv[2];
  options.scene = argv[3];
  options.program = "gnomon's example in C";
  options.open_timeout_ms = WAIT_MS;
  gnomon_result result = gnomon_open(&options, &client);
  if (result == GNOMON_OK) result = gnomon_wait_open(client, WAIT_MS);
  const int failed = result == GNOMON_OK
                         ? fly(client, (uint32_t)strtoul(argv[5], NULL, 10), argc > 6 ? argv[6] : NULL)
                         : fail(argv[1], result, client);
  gnomon_close(client, failed ? "failed" : "done");
  gnomon_free(client);
  return failed;
}
