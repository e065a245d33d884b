// Answers what browsers ask about scenes: who asks is identified as by a Hello, the scene is read and made resident as
// for a session, and its pack is made once. A rule of admission that holds for scenes too has to be added here as well as
// in Admission::take_steps.
#pragma once

#include <asio/awaitable.hpp>
#include <asio/io_context.hpp>

#include <memory>
#include <optional>
#include <stop_token>

#include "daemon/net/control_stream.h"
#include "daemon/net/net_shared.h"
#include "daemon/web/scene_pages.h"

namespace gnomon::daemon {

// The net thread of the stream; precondition: `shared.web` is set. nullopt once `departure` is stopped. While others work
// for it the request holds a session's permit, so that who may open no further session makes the server read no further
// scene either.
asio::awaitable<std::optional<web::Response>> answer_about_scene(const NetShared& shared, asio::io_context& io,
                                                                 std::shared_ptr<ControlStream> stream,
                                                                 web::Request request, web::SceneTarget target,
                                                                 std::stop_token departure);

}  // namespace gnomon::daemon
