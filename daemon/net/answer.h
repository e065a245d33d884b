// Lets a coroutine on an event loop wait for the answer of another thread.
#pragma once

#include <asio/awaitable.hpp>
#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <asio/redirect_error.hpp>
#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>

#include "common/clock.h"
#include "common/within_memory.h"

namespace gnomon::daemon {

// How often a client that came before the devices are open looks whether they are.
inline constexpr std::chrono::milliseconds kBetweenLooks{20};

// Receives the answer. May be called once, on any thread, while the event loop exists.
template <typename Answer>
using OnAnswer = std::function<void(Answer)>;

// Asks another thread, which calls the OnAnswer at once or later.
template <typename Answer>
using Ask = std::function<void(OnAnswer<Answer>)>;

// The state of a waiting coroutine.
template <typename Answer>
struct Awaited {
  asio::steady_timer timer;  // never expires; cancelled when the answer has arrived or nobody needs it any more
  std::optional<Answer> answer;
};

// Calls `ask` and returns the answer; nullopt once `unwanted` is stopped, which happens on the event loop's thread. An
// answer that comes later is dropped. If there is never an answer, the coroutine waits until `io` is destroyed, and is
// destroyed with it. Precondition: `io` runs on one thread, the caller's.
template <typename Answer>
asio::awaitable<std::optional<Answer>> answer_of(asio::io_context& io, const Ask<Answer>& ask,
                                                 std::stop_token unwanted = {}) {
  const auto awaited =
      std::make_shared<Awaited<Answer>>(Awaited<Answer>{asio::steady_timer(io, TimePoint::max()), std::nullopt});
  ask([&io, weak = std::weak_ptr<Awaited<Answer>>(awaited)](Answer answer) {
    std::shared_ptr<Answer> given;
    until_memory_suffices(
        [&] { given = std::make_shared<Answer>(std::move(answer)); });  // moves nothing if it fails
    until_memory_suffices([&] {
      asio::post(io, [weak, given] {
        const auto still_awaited = weak.lock();
        if (!still_awaited) return;
        still_awaited->answer.emplace(std::move(*given));
        still_awaited->timer.cancel();
      });
    });
  });
  const std::stop_callback give_up(std::move(unwanted), [&timer = awaited->timer] {
    timer.expires_at(TimePoint::min());  // which also ends a wait that begins only now
  });
  asio::error_code cancelled;
  co_await awaited->timer.async_wait(asio::redirect_error(asio::use_awaitable, cancelled));
  co_return std::move(awaited->answer);
}

}  // namespace gnomon::daemon
