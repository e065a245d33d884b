#include "daemon/security/private_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace gnomon::daemon {

// PostgreSQL's rule: only the owner may read the file, or it belongs to root and its group may read it.
Result<void> check_private(const std::string& key, const std::filesystem::path& file) {
  struct stat info {};
  if (stat(file.c_str(), &info) != 0) {
    return Error{key + ": " + file.string() + ": " + std::system_category().message(errno)};
  }
  const bool of_root = info.st_uid == 0;
  if ((info.st_mode & (of_root ? 027u : 077u)) == 0) return {};
  return Error{key + ": " + file.string() + " may be read by others; allowed: mode 0600, or 0640 if it is " +
               "root's. chmod go= " + file.string()};
}

}  // namespace gnomon::daemon
