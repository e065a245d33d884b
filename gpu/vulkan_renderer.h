// The real Renderer: one Vulkan device, several frames in flight, a completion thread for each queue.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "gpu/renderer.h"
#include "gpu/tracers/tracer_options.h"
#include "gpu/vulkan/device.h"

namespace gnomon::gpu {

struct RendererOptions {
  std::string device;           // "" for the best one, an index, a type (cpu, discrete, ...) or part of a name
  std::string tracer = "auto";  // see make_tracer
  std::string raster = "auto";  // see choose_raster
  TracerOptions tracer_options;
  std::vector<std::string> passes{"gbuffer", "trace", "pack", "readback"};
  uint32_t frames_in_flight = 3;
  // That frames are spread over, so that they overlap; at most as the device has. 0: three if nothing is drawn by the
  // graphics pipeline and the device has queues for compute alone, else one.
  uint32_t queues = 0;
  bool wait_for_builds = true;  // a scene is resident after all builds; false: rebuild_lights does the long ones
  ValidationOptions validation;
  bool texel_loads = true;  // see DeviceOptions
};

// What of the options is wrong as far as it can be told without opening a device: errors that begin with "device: ",
// "tracer: " or "passes: ".
std::vector<Error> check_options(const RendererOptions& options);

// Error: there is no such device, tracer or pass; or out of memory. Leases may outlive the renderer: the device is
// closed when the last lease is dropped. Destroying the renderer waits for the frames in flight and delivers them.
Result<std::unique_ptr<Renderer>> make_renderer(const RendererOptions& options);

}  // namespace gnomon::gpu
