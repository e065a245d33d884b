#include "daemon/admin/unix_socket.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace gnomon::daemon {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kMode = 0660;

class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  int get() const { return value_; }
  int release() { return std::exchange(value_, -1); }

 private:
  int value_;
};

Error failure(const fs::path& path, const std::string& what) {
  return Error{path.string() + ": " + what + ": " + std::strerror(errno)};
}

Descriptor new_socket() { return Descriptor(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)); }

const sockaddr* generic(const sockaddr_un& address) { return reinterpret_cast<const sockaddr*>(&address); }

bool somebody_listens(const sockaddr_un& address) {
  const Descriptor probe = new_socket();
  return connect(probe.get(), generic(address), sizeof address) == 0 || errno == EAGAIN;
}

// What is at the path may be removed if it is a socket and nobody listens on it.
Result<void> remove_stale(const fs::path& path, const sockaddr_un& address) {
  struct stat info {};
  if (lstat(path.c_str(), &info) != 0) return {};
  if (!S_ISSOCK(info.st_mode)) return Error{path.string() + ": is there and no socket"};
  if (somebody_listens(address)) return Error{path.string() + ": another process listens there"};
  if (unlink(path.c_str()) != 0) return failure(path, "is stale and cannot be removed");
  return {};
}

}  // namespace

UnixSocket::UnixSocket(fs::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {
  struct stat info {};
  if (lstat(path_.c_str(), &info) != 0) return;
  device_ = info.st_dev;
  inode_ = info.st_ino;
}

UnixSocket::~UnixSocket() {
  struct stat info {};
  const bool still_ours = lstat(path_.c_str(), &info) == 0 && info.st_dev == device_ && info.st_ino == inode_;
  if (still_ours) unlink(path_.c_str());
  if (descriptor_ >= 0) close(descriptor_);
}

int UnixSocket::take() { return std::exchange(descriptor_, -1); }

Result<std::unique_ptr<UnixSocket>> UnixSocket::listen(const fs::path& path, std::optional<gid_t> group) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.native().size() >= sizeof address.sun_path) {
    return Error{path.string() + ": is longer than a socket's path may be, " +
                 std::to_string(sizeof address.sun_path - 1) + " bytes"};
  }
  std::memcpy(address.sun_path, path.c_str(), path.native().size());
  // The lock is held until we listen, so that of two daemons that start at once none takes the other's for stale.
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const Descriptor lock(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock.get() < 0 || flock(lock.get(), LOCK_EX) != 0) return failure(folder, "cannot be opened");
  if (auto free = remove_stale(path, address); !free) return free.error();
  Descriptor made = new_socket();
  if (made.get() < 0 || bind(made.get(), generic(address), sizeof address) != 0) {
    return failure(path, "cannot be made");
  }
  std::unique_ptr<UnixSocket> opened(new UnixSocket(path, made.release()));
  // Nobody connects before listen(): the mode is right from the first connection on.
  const bool given = !group || group == getegid() || lchown(path.c_str(), static_cast<uid_t>(-1), *group) == 0;
  if (!given) return failure(path, "cannot be given to the group, which we have to belong to");
  if (chmod(path.c_str(), kMode) != 0) return failure(path, "cannot get its mode");
  if (::listen(opened->descriptor_, SOMAXCONN) != 0) return failure(path, "cannot be listened on");
  return opened;
}

std::optional<PeerCredentials> peer_of(int connection) {
  ucred process{};
  socklen_t size = sizeof process;
  if (getsockopt(connection, SOL_SOCKET, SO_PEERCRED, &process, &size) != 0) return std::nullopt;
  PeerCredentials peer{process.uid, {process.gid}};
  std::vector<gid_t> groups(64);
  size = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
  int read = getsockopt(connection, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size);
  if (read != 0 && errno == ERANGE) {  // it has more, and `size` says how many bytes they take
    groups.resize(size / sizeof(gid_t));
    read = getsockopt(connection, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size);
  }
  if (read == 0) peer.groups.insert(peer.groups.end(), groups.begin(), groups.begin() + size / sizeof(gid_t));
  return peer;
}

}  // namespace gnomon::daemon
