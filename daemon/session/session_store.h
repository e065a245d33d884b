// What of a session outlives its control connection, and this process: enough to go on with the same keys. It lies in
// shared memory that a service manager may keep for us (systemd's file descriptor store), so that it is there after a
// crash, whatever instruction was the last one.
//
//   session opened: add()    its client is back on another connection: claim()    session closed: KeptSession::forget()
//
// A record whose user is gone without a word rests, for so long as a silent session may, until it is claimed.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/clock.h"
#include "common/ids.h"
#include "common/result.h"
#include "protocol/seal.h"

namespace gnomon::daemon {

// Plain: what another process with the same program finds as we left it. Texts end with a zero.
struct SessionRecord {
  uint64_t id = 0;  // 0: free
  uint64_t features = 0;
  uint32_t newest_frame = 0;  // that the client asked for; 0: none yet
  uint32_t life = 0;          // how often it was resumed
  float rate_hz = 0;
  uint16_t width = 0, height = 0;
  protocol::CodecId codec{}, dense_codec{};
  protocol::CipherId cipher{};
  std::array<char, 257> tenant{};
  std::array<char, 1025> scene{};
  protocol::Bytes16 scene_hash{};
  protocol::Secret resumption{};
  protocol::SealState seal = {};
};

class SessionStore;

// The use of a record, by one thread at a time. Dropped, the record rests. Move-only; outlived by its store.
class KeptSession {
 public:
  KeptSession() = default;
  KeptSession(KeptSession&& other) noexcept : store_(std::exchange(other.store_, nullptr)), place_(other.place_) {}
  KeptSession& operator=(KeptSession&& other) noexcept {
    std::swap(store_, other.store_);
    std::swap(place_, other.place_);
    return *this;
  }
  ~KeptSession();

  explicit operator bool() const { return store_ != nullptr; }
  SessionRecord& record() const;

  // Called when the client has come back on another connection: this is to be dropped soon. Any thread; does not block.
  void when_wanted(std::function<void()> wanted);

  void forget();  // wipes the record; nobody claims it any more

 private:
  friend class SessionStore;
  KeptSession(SessionStore* store, size_t place) : store_(store), place_(place) {}

  SessionStore* store_ = nullptr;
  size_t place_ = 0;
};

// Any thread.
class SessionStore {
 public:
  // `left`: memory that an earlier life left, taken over, and used if it is of this shape. Error: no memory.
  static Result<std::unique_ptr<SessionStore>> open(size_t most, Nanoseconds patience, std::optional<int> left);
  ~SessionStore();

  int descriptor() const { return memory_; }
  bool taken_over() const { return taken_over_; }  // `left` was used
  size_t resting() const;

  // Empty: there is no room for it.
  KeptSession add(const SessionRecord& record);

  // What the client of that session proves that it knows.
  std::optional<protocol::Secret> resumption_secret(SessionId id) const;

  // `done` is called once, on any thread, as soon as nobody else uses the record; with nothing if there is none (any
  // more), or if it is claimed again meanwhile.
  using Claimed = std::function<void(KeptSession)>;
  void claim(SessionId id, Claimed done);

  // Wipes what has rested for too long, counted from the first call for what an earlier life left.
  void expire(TimePoint now);
  void forget_resting();

  void close();  // nobody is called any more

 private:
  friend class KeptSession;

  struct Place {
    bool used = false;
    std::optional<TimePoint> rests_until;
    std::function<void()> wanted;
    Claimed claimed;  // somebody waits for it
  };

  SessionStore(size_t most, Nanoseconds patience) : patience_(patience), places_(most) {}
  Result<void> map(std::optional<int> left);
  bool is_ours(int memory) const;
  size_t bytes() const;
  void find_left();
  void rest(size_t place);
  void forget(size_t place);
  Claimed wipe(size_t place);
  void when_wanted(size_t place, std::function<void()> wanted);

  const Nanoseconds patience_;
  int memory_ = -1;
  bool taken_over_ = false;
  std::span<SessionRecord> records_;
  void* mapped_ = nullptr;

  mutable std::mutex mutex_;  // guards what follows, and the ids of the records
  std::vector<Place> places_;
  std::vector<size_t> free_;
  bool closed_ = false;
  std::unordered_map<SessionId, size_t> by_id_;
};

}  // namespace gnomon::daemon
