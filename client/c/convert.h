// Conversions between the structs of gnomon.h and the client's own values.
#pragma once

#include <gnomon/gnomon.h>

#include "client/thin_client.h"
#include "common/result.h"
#include "protocol/types.h"

namespace gnomon::client::c {

protocol::CameraView to_camera(const gnomon_camera& camera);
gnomon_camera to_c(const protocol::CameraView& camera);
gnomon_light to_c(const protocol::LightInfo& light);
gnomon_motion to_c(const protocol::NodeMotion& motion);  // its text is borrowed from `motion`

// Error: names the invalid member, and says why.
Result<ThinClientOptions> to_options(const gnomon_options& options);

}  // namespace gnomon::client::c
