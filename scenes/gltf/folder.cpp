#include "scenes/gltf/folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "scenes/gltf/uri.h"

namespace gnomon::scenes::gltf {
namespace fs = std::filesystem;
namespace {

class Descriptor {
 public:
  // O_NONBLOCK: opening a pipe must not wait for its writer.
  explicit Descriptor(const fs::path& file)
      : fd_(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK)) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

std::string quoted(const std::string& text) {
  std::string out(1, '\'');
  out += text;
  out += '\'';
  return out;
}

std::string reason(int error) { return std::generic_category().message(error); }

bool within(const fs::path& folder, const fs::path& file) {
  const auto [end_of_folder, rest] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return end_of_folder == folder.end() && rest != file.end();
}

}  // namespace

Result<Folder> Folder::of(const fs::path& file) {
  std::error_code error;
  fs::path canonical = fs::canonical(file, error);
  if (error) return Error{"cannot open it: " + error.message()};
  return Folder(std::move(canonical));
}

Result<Bytes> Folder::read_scene_file(Budget& budget) { return read_regular(file_, budget); }

Result<Bytes> Folder::read(const std::string& uri, Budget& budget) {
  const std::string name = percent_decoded(uri);
  const fs::path relative(name);
  if (name.empty() || name.find('\0') != std::string::npos || relative.is_absolute()) {
    return Error{quoted(uri) + " is not the name of a file in the scene's folder"};
  }
  const fs::path folder = file_.parent_path();
  std::error_code error;
  const fs::path canonical = fs::canonical(folder / relative, error);
  if (error) return Error{"cannot open " + quoted(uri) + ": " + error.message()};
  if (!within(folder, canonical)) return Error{quoted(uri) + " lies outside the scene's folder"};
  return read_regular(canonical, budget);
}

Result<Bytes> Folder::read_regular(const fs::path& file, Budget& budget) {
  const std::string name = quoted(file.filename().string());
  const Descriptor descriptor(file);
  struct stat status {};
  if (descriptor.get() < 0 || fstat(descriptor.get(), &status) != 0) {
    return Error{"cannot open " + name + ": " + reason(errno)};
  }
  if (!S_ISREG(status.st_mode)) return Error{name + " is not a regular file"};
  const auto size = static_cast<uint64_t>(status.st_size);
  const bool first = seen_.emplace(status.st_dev, status.st_ino).second;
  const auto granted = first ? budget.read(size) : budget.spend(size);
  if (!granted) return Error{name + (first ? " " : " is named again and again: it ") + granted.error().message};

  Bytes bytes(size);
  size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t got = ::read(descriptor.get(), bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return Error{"cannot read " + name + ": " + reason(errno)};
    if (got == 0) break;
    filled += static_cast<size_t>(got);
  }
  bytes.resize(filled);
  return bytes;
}

}  // namespace gnomon::scenes::gltf
