#include "daemon/net/net_thread.h"

#include <asio/post.hpp>
#include <future>

#include "common/within_memory.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr auto kTick = 50ms;
constexpr auto kReview = 1s;                 // between two looks for credentials that have expired
constexpr auto kFarewellTime = 100ms;        // for the last messages to clients when the server stops
constexpr auto kAnswerTime = 1s;             // for this thread to answer another; after it, it must have ended
constexpr uint32_t kMaxFramesWaiting = 256;  // encoded frames that wait for this thread to send them

}  // namespace

NetThread::NetThread(const NetShared& shared, uint32_t index)
    : shared_(shared),
      index_(index),
      pending_(std::max(1u, shared.config.server.max_half_open / shared.config.server.net_threads)) {}

Result<std::unique_ptr<NetThread>> NetThread::open(const NetShared& shared, uint32_t index) {
  std::unique_ptr<NetThread> made(new NetThread(shared, index));
  const ServerConfig& server = shared.config.server;
  const auto port = static_cast<uint16_t>(server.data_port == 0 ? 0 : server.data_port + index);
  const auto opened = made->links_.open({asio::ip::make_address(server.listen), port});
  if (!opened) return opened.error();
  made->admission_.emplace(made->shared_, made->data_port(), made->io_, made->control_, made->pending_);
  return made;
}

NetThread::~NetThread() { stop(); }

void NetThread::run() {
  links_.start();
  tick();
  thread_ = std::thread([this] { serve(); });
}

// What runs out of memory costs one event, and its connection or session at most.
void NetThread::serve() {
  while (!done_or_dropped("an event of the network", [this] { io_.run(); })) {
  }
}

void NetThread::stop(bool for_good) {
  if (!thread_.joinable()) return;
  until_memory_suffices([&] {
    asio::post(io_, [this, for_good] {
      done_or_dropped("the farewell to clients", [&] { control_.end_all(for_good); });
      links_.close();
      stop_when_all_left(Clock::now() + kFarewellTime);
    });
  });
  thread_.join();
}

void NetThread::stop_when_all_left(TimePoint deadline) {
  const TimePoint now = Clock::now();
  pending_.expire(now);
  if (pending_.size() == 0 || now >= deadline) return io_.stop();
  until_memory_suffices([&] {
    timer_.expires_after(1ms);  // this replaces the tick
    timer_.async_wait([this, deadline](asio::error_code) { stop_when_all_left(deadline); });
  });
}

void NetThread::tick() {
  done_or_dropped("a look at the sessions", [this] { review(Clock::now()); });
  until_memory_suffices([this] {
    timer_.expires_after(kTick);
    timer_.async_wait([this](asio::error_code error) {
      if (!error) tick();
    });
  });
}

void NetThread::review(TimePoint now) {
  control_.close_silent(now);
  if (now >= next_review_) {
    control_.close_unwelcome();
    links_.web_transport().review(now);
    next_review_ = now + kReview;
  }
  if (index_ == 0) shared_.store.expire(now);
  admission_->close_overdue(now);
  statistics_.tick(now);
}

void NetThread::adopt(asio::ip::tcp::socket socket, const asio::ip::address& client) {
  asio::post(io_, [this, client, socket = std::move(socket)]() mutable {
    admission_->on_accept(std::move(socket), client);
  });
}

void NetThread::deliver(EncodedFrame frame) {
  if (frames_waiting_.fetch_add(1) >= kMaxFramesWaiting) {
    frames_waiting_.fetch_sub(1);
    const FrameRoute& route = frame.meta.route;
    return shared_.metrics.dropped(route.tenant, route.session, Fault::send_queue_full);
  }
  const bool posted = done_or_dropped("an encoded frame", [&] {
    asio::post(io_, [this, frame = std::move(frame)]() mutable {
      frames_waiting_.fetch_sub(1);
      links_.send(frame);
    });
  });
  if (!posted) frames_waiting_.fetch_sub(1);
}

void NetThread::notify(const SessionDegraded& session) {
  asio::post(io_, [this, session] { control_.notify(session); });
}

bool NetThread::kick(SessionId id, const Kick& kick) {
  auto answer = std::make_shared<std::promise<bool>>();
  std::future<bool> kicked = answer->get_future();
  asio::post(io_, [this, id, kick, answer] {
    answer->set_value(sessions_.find(id) != nullptr);
    control_.kick(id, kick);
  });
  return kicked.wait_for(kAnswerTime) == std::future_status::ready && kicked.get();
}

void NetThread::announce_drain(std::chrono::milliseconds deadline) {
  asio::post(io_, [this, deadline] { control_.announce_drain(deadline); });
}

void NetThread::ask_to_move(bool move) {
  asio::post(io_, [this, move] { control_.ask_to_move(move); });
}

void NetThread::announce_lights(const LightsUpdate& update) {
  asio::post(io_, [this, update] { control_.announce_lights(update); });
}

void NetThread::close_unwelcome() {
  asio::post(io_, [this] { control_.close_unwelcome(); });
}

}  // namespace gnomon::daemon
