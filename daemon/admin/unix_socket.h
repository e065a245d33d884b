// The socket in the file system through which operators of this machine reach the admin server.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "common/result.h"
#include "daemon/admin/http_message.h"

namespace gnomon::daemon {

// Open from open() on; its end removes the file, unless another has taken its place. One thread.
class UnixSocket {
 public:
  // Listens at `path` with mode 0660, for `group` if there is one. A socket that is there already is replaced, unless
  // somebody listens on it. Makes no folder. The error names the path and the reason.
  static Result<std::unique_ptr<UnixSocket>> listen(const std::filesystem::path& path, std::optional<gid_t> group);
  ~UnixSocket();

  const std::filesystem::path& path() const { return path_; }
  int take();  // the descriptor, which the caller owns from then on; once

 private:
  UnixSocket(std::filesystem::path path, int descriptor);

  const std::filesystem::path path_;
  int descriptor_;  // -1: taken
  dev_t device_ = 0;
  ino_t inode_ = 0;
};

// Who is at the other end of a connection; nullopt if the kernel does not say.
std::optional<PeerCredentials> peer_of(int connection);

}  // namespace gnomon::daemon
