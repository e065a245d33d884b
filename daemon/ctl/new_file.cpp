#include "daemon/ctl/new_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

namespace gnomon::ctl {

std::string read_file(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

Result<void> write_file(const std::filesystem::path& file, const std::string& text, mode_t mode) {
  const std::filesystem::path unfinished = file.string() + ".new";
  unlink(unfinished.c_str());
  const int out = open(unfinished.c_str(), O_WRONLY | O_CREAT | O_EXCL, mode);
  // Of a mode that the process's mask does not narrow.
  const bool made = out >= 0 && fchmod(out, mode) == 0;
  const bool written = made && ::write(out, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (out >= 0) close(out);
  if (!written || rename(unfinished.c_str(), file.c_str()) != 0) {
    return Error{file.string() + ": cannot be written: " + std::strerror(errno)};
  }
  return {};
}

}  // namespace gnomon::ctl
