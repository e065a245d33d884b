#include "daemon/session/session_store.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <type_traits>
#include <utility>

namespace gnomon::daemon {
namespace {

struct Head {
  std::array<char, 16> magic{};
  uint64_t layout = 0;
  uint64_t record_bytes = 0;
  uint64_t records = 0;
  friend bool operator==(const Head&, const Head&) = default;
};
static_assert(sizeof(Head) % alignof(SessionRecord) == 0);
static_assert(std::is_trivially_copyable_v<SessionRecord>);

// The layout counts up with every change to SessionRecord or to what its fields mean.
Head head_of(size_t records) {
  return {{'g', 'n', 'o', 'm', 'o', 'n', ' ', 's', 'e', 's', 's', 'i', 'o', 'n', 's'},
          2,
          sizeof(SessionRecord),
          records};
}

Error system_error(const char* what) { return Error{std::string(what) + ": " + std::strerror(errno)}; }

// Keeps the compiler from reordering stores across it. A process that reads the memory after this one has ended sees
// every store that was executed, so that no hardware fence is needed.
void in_this_order() { std::atomic_signal_fence(std::memory_order_seq_cst); }

}  // namespace

StoredSession::~StoredSession() {
  if (store_) store_->rest(place_);
}

SessionRecord& StoredSession::record() const { return store_->records_[place_]; }

void StoredSession::when_wanted(std::function<void()> wanted) { store_->when_wanted(place_, std::move(wanted)); }

void StoredSession::forget() {
  if (SessionStore* const store = std::exchange(store_, nullptr)) store->forget(place_);
}

Result<std::unique_ptr<SessionStore>> SessionStore::open(size_t most, Nanoseconds patience,
                                                         std::optional<int> left) {
  std::unique_ptr<SessionStore> made(new SessionStore(most, patience));
  if (auto mapped = made->map(left); !mapped) return mapped.error();
  made->find_left();
  return made;
}

SessionStore::~SessionStore() {
  if (mapped_) munmap(mapped_, bytes());
  if (memory_ >= 0) ::close(memory_);
}

size_t SessionStore::bytes() const { return sizeof(Head) + places_.size() * sizeof(SessionRecord); }

// Accepts only memory of the expected size that is sealed against shrinking, so that no access is a bus error.
bool SessionStore::is_ours(int memory) const {
  struct stat status {};
  if (fstat(memory, &status) != 0 || static_cast<size_t>(status.st_size) != bytes()) return false;
  const int seals = fcntl(memory, F_GET_SEALS);
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0) return false;
  Head head;
  return pread(memory, &head, sizeof head, 0) == sizeof head && head == head_of(places_.size());
}

Result<void> SessionStore::map(std::optional<int> left) {
  if (left && is_ours(*left)) {
    memory_ = *left;
    taken_over_ = true;
  } else {
    if (left) ::close(*left);
    memory_ = memfd_create("gnomon-sessions", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    const Head head = head_of(places_.size());
    if (memory_ < 0 || ftruncate(memory_, static_cast<off_t>(bytes())) != 0 ||
        fcntl(memory_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0 ||
        pwrite(memory_, &head, sizeof head, 0) != sizeof head) {
      return system_error("memory for sessions");
    }
  }
  void* const mapped = mmap(nullptr, bytes(), PROT_READ | PROT_WRITE, MAP_SHARED, memory_, 0);
  if (mapped == MAP_FAILED) return system_error("memory for sessions");
  mapped_ = mapped;
  madvise(mapped_, bytes(), MADV_DONTDUMP);  // keeps the keys out of core dumps
  records_ = {reinterpret_cast<SessionRecord*>(static_cast<char*>(mapped_) + sizeof(Head)), places_.size()};
  return {};
}

void SessionStore::find_left() {
  for (size_t place = places_.size(); place-- > 0;) {
    SessionRecord& record = records_[place];
    record.tenant.back() = record.scene.back() = 0;
    if (record.id != 0 && by_id_.emplace(SessionId{record.id}, place).second) {
      places_[place].used = false;
      continue;
    }
    protocol::wipe(&record, sizeof record);  // it may have been half written or half wiped
    free_.push_back(place);
  }
}

size_t SessionStore::resting() const {
  std::lock_guard lock(mutex_);
  size_t count = 0;
  for (const auto& [id, place] : by_id_) count += places_[place].used ? 0 : 1;
  return count;
}

StoredSession SessionStore::add(const SessionRecord& record) {
  std::lock_guard lock(mutex_);
  if (free_.empty() || !by_id_.emplace(SessionId{record.id}, free_.back()).second) return {};
  const size_t place = free_.back();
  free_.pop_back();
  places_[place].used = true;
  SessionRecord staged = record;
  staged.id = 0;
  records_[place] = staged;
  in_this_order();
  records_[place].id = record.id;
  protocol::wipe(&staged, sizeof staged);
  return {this, place};
}

std::optional<protocol::Secret> SessionStore::resumption_secret(SessionId id) const {
  std::lock_guard lock(mutex_);
  const auto found = by_id_.find(id);
  if (found == by_id_.end()) return std::nullopt;
  return records_[found->second].resumption;
}

void SessionStore::claim(SessionId id, Claimed done) {
  std::unique_lock lock(mutex_);
  const auto found = by_id_.find(id);
  if (closed_ || found == by_id_.end()) {
    lock.unlock();
    return done({});
  }
  const size_t number = found->second;
  Place& place = places_[number];
  if (!std::exchange(place.used, true)) {
    place.rests_until.reset();
    lock.unlock();
    return done({this, number});
  }
  const Claimed earlier = std::exchange(place.claimed, std::move(done));
  const auto wanted = place.wanted;
  lock.unlock();
  if (earlier) earlier({});
  if (wanted) wanted();
}

void SessionStore::when_wanted(size_t number, std::function<void()> wanted) {
  std::unique_lock lock(mutex_);
  Place& place = places_[number];
  place.wanted = wanted;
  const bool already = static_cast<bool>(place.claimed);
  lock.unlock();
  if (already) wanted();
}

void SessionStore::rest(size_t number) {
  std::unique_lock lock(mutex_);
  Place& place = places_[number];
  place.wanted = nullptr;
  const Claimed claimed = std::exchange(place.claimed, nullptr);
  if (!claimed) {
    place.used = false;
    place.rests_until = Clock::now() + patience_;
    return;
  }
  lock.unlock();
  claimed({this, number});
}

void SessionStore::forget(size_t place) {
  std::unique_lock lock(mutex_);
  const Claimed claimed = wipe(place);
  lock.unlock();
  if (claimed) claimed({});
}

SessionStore::Claimed SessionStore::wipe(size_t place) {
  SessionRecord& record = records_[place];
  by_id_.erase(SessionId{record.id});
  record.id = 0;
  in_this_order();
  protocol::wipe(&record, sizeof record);
  free_.push_back(place);
  return std::exchange(places_[place], {}).claimed;
}

void SessionStore::expire(TimePoint now) {
  std::lock_guard lock(mutex_);
  std::vector<size_t> over;
  for (const auto& [id, number] : by_id_) {
    Place& place = places_[number];
    if (place.used) continue;
    if (!place.rests_until) place.rests_until = now + patience_;
    if (*place.rests_until <= now) over.push_back(number);
  }
  for (const size_t number : over) wipe(number);
}

void SessionStore::close() {
  std::vector<Claimed> dropped;  // destroyed after the lock is released, as they may hold records of this store
  std::lock_guard lock(mutex_);
  closed_ = true;
  for (Place& place : places_) {
    place.wanted = nullptr;
    if (place.claimed) dropped.push_back(std::exchange(place.claimed, nullptr));
  }
}

void SessionStore::forget_resting() {
  std::lock_guard lock(mutex_);
  std::vector<size_t> resting;
  for (const auto& [id, number] : by_id_) {
    if (!places_[number].used) resting.push_back(number);
  }
  for (const size_t number : resting) wipe(number);
}

}  // namespace gnomon::daemon
