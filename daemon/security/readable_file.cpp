#include "daemon/security/readable_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace gnomon::daemon {
namespace {

namespace fs = std::filesystem;

Error error_of(const fs::path& file, int code) {
  return Error{file.string() + ": " + std::system_category().message(code)};
}

class Descriptor {
 public:
  explicit Descriptor(const fs::path& file) : number_(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

// At most `most` bytes of the file.
Result<std::string> read_up_to(const fs::path& file, size_t most) {
  const Descriptor opened(file);
  if (opened.number() < 0) return error_of(file, errno);
  std::string text;
  std::array<char, 65536> part;
  while (text.size() < most) {
    const ssize_t got = read(opened.number(), part.data(), std::min(part.size(), most - text.size()));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return error_of(file, errno);
    if (got == 0) break;
    text.append(part.data(), static_cast<size_t>(got));
  }
  if (text.empty()) return Error{file.string() + ": the file is empty"};
  return text;
}

// 0, or why no file can be made in the folder: the rights alone do not tell, as of /proc, whose files are all the
// system's. What is made is gone again at once. A full disk is left to who writes.
int try_to_make_file(const fs::path& folder) {
  int made = open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
  if (made < 0) {  // not every file system has files without a name
    std::string name = (folder / ".gnomon_XXXXXX").string();
    made = mkostemp(name.data(), O_CLOEXEC);
    if (made >= 0) unlink(name.c_str());
  }
  const int error = errno;
  if (made >= 0) close(made);
  return made >= 0 || error == ENOSPC || error == EDQUOT ? 0 : error;
}

}  // namespace

Result<std::string> read_file(const fs::path& file) { return read_up_to(file, std::string::npos); }

Result<void> check_readable(const fs::path& file) {
  const auto read = read_up_to(file, 1);
  return read ? Result<void>() : read.error();
}

Result<void> check_writable_folder(const fs::path& folder) {
  fs::path nearest = folder;
  while (access(nearest.c_str(), F_OK) != 0 && errno == ENOENT && nearest.has_relative_path()) {
    nearest = nearest.parent_path();
  }
  if (access(nearest.c_str(), F_OK) != 0) return error_of(nearest, errno);
  std::error_code ignored;
  if (!fs::is_directory(nearest, ignored)) return error_of(nearest, ENOTDIR);
  if (access(nearest.c_str(), W_OK | X_OK) != 0) return error_of(nearest, errno);
  const int error = try_to_make_file(nearest);
  if (error == ENOENT) return Error{nearest.string() + ": no file can be made there"};  // but the folder is there
  if (error != 0) return error_of(nearest, error);
  return {};
}

}  // namespace gnomon::daemon
