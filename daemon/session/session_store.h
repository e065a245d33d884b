// The part of a session that outlives its control connection and this process: enough to continue with the same keys.
// It is in shared memory that a service manager may keep for the next process (systemd's file descriptor store), so
// that it survives a crash at any instruction.
//
//   session opened: add()   its client is back on another connection: claim()   session closed: StoredSession::forget()
//
// A record whose StoredSession is dropped without forget() rests: it can be claimed for as long as a session may be
// silent.
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
#include "daemon/frame/credential.h"
#include "protocol/seal.h"

namespace gnomon::daemon {

// Plain memory, read by another process of the same program. Texts are terminated by a zero byte.
struct SessionRecord {
  uint64_t id = 0;  // 0: free
  uint64_t features = 0;
  uint32_t newest_frame = 0;  // the newest that the client asked for; 0 if it asked for none
  uint32_t generation = 0;    // counts how often it was resumed
  float rate_hz = 0;
  uint16_t width = 0, height = 0;
  protocol::CodecId codec{}, dense_codec{};
  protocol::CipherId cipher{};
  uint8_t samples = 1;  // as to_byte(SampleCounts)
  Credential credential;
  std::array<char, 257> tenant{};
  std::array<char, 1025> scene{};
  protocol::Bytes16 scene_hash{};
  protocol::Secret resumption{};
  protocol::SealState seal = {};
};

class SessionStore;

// The exclusive use of a record. When it is dropped, the record rests. One thread at a time. Move-only; outlived by its
// store.
class StoredSession {
 public:
  StoredSession() = default;
  StoredSession(StoredSession&& other) noexcept
      : store_(std::exchange(other.store_, nullptr)), place_(other.place_) {}
  StoredSession& operator=(StoredSession&& other) noexcept {
    std::swap(store_, other.store_);
    std::swap(place_, other.place_);
    return *this;
  }
  ~StoredSession();

  explicit operator bool() const { return store_ != nullptr; }
  SessionRecord& record() const;

  // `wanted` is called when the client has come back on another connection: the holder should drop this object soon. It
  // is called on any thread and must not block.
  void when_wanted(std::function<void()> wanted);

  void forget();  // wipes the record, which can no longer be claimed

 private:
  friend class SessionStore;
  StoredSession(SessionStore* store, size_t place) : store_(store), place_(place) {}

  SessionStore* store_ = nullptr;
  size_t place_ = 0;
};

// Any thread.
class SessionStore {
 public:
  // `most`: number of records. `patience`: how long a record rests. `left`: memory of a previous process, nullopt if
  // there is none; the store owns it from now on, and uses it if it has the right shape. Error if memory cannot be
  // allocated.
  static Result<std::unique_ptr<SessionStore>> open(size_t most, Nanoseconds patience, std::optional<int> left);
  ~SessionStore();

  int descriptor() const { return memory_; }
  bool taken_over() const { return taken_over_; }  // `left` was used
  size_t resting() const;

  // Returns an empty StoredSession if there is no room for the record.
  StoredSession add(const SessionRecord& record);

  // The secret that the client of that session has to prove that it knows; nullopt if there is no such session.
  std::optional<protocol::Secret> resumption_secret(SessionId id) const;

  // `done` is called once, on any thread, as soon as nobody else uses the record. Its argument is empty if there is no
  // such record or if the record is claimed again meanwhile. close() drops claims that wait without a call.
  using Claimed = std::function<void(StoredSession)>;
  void claim(SessionId id, Claimed done);

  // Wipes records that have rested for longer than `patience`, counted from the first call for those of a previous
  // process.
  void expire(TimePoint now);
  void forget_resting();  // wipes all records that rest

  void close();  // drops the callbacks; later claims get an empty answer at once

 private:
  friend class StoredSession;

  struct Place {
    bool used = false;
    std::optional<TimePoint> rests_until;
    std::function<void()> wanted;
    Claimed claimed;  // of the claim that waits for the record
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
