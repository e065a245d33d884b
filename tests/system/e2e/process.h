// A program of this build, run as a child.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace gnomon::tests {

// Generous, for a machine that does other things too: only what hangs takes this long.
#ifdef __SANITIZE_THREAD__
inline constexpr std::chrono::seconds kPatience{300};
#else
inline constexpr std::chrono::seconds kPatience{60};
#endif

// Asks again and again until `done` or until patience ends.
bool eventually(const std::function<bool()>& done, std::chrono::seconds patience = kPatience);

// A folder that goes with the test.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

class Process {
 public:
  // `program` is a name in this build's bin/. Standard output and error go to a file of `folder`.
  Process(const std::string& program, const std::vector<std::string>& arguments,
          const std::filesystem::path& folder);
  ~Process();  // kills what still runs
  Process(const Process&) = delete;

  void signal(int number) const;
  bool running();
  // Exit status, or minus the signal that ended it; empty when it still runs after the patience.
  std::optional<int> wait(std::chrono::seconds patience = kPatience);
  std::string output() const;

 private:
  std::filesystem::path output_;
  pid_t pid_ = -1;
  std::optional<int> status_;
};

// Runs to the end.
struct Finished {
  int status;
  std::string output;
};
Finished run(const std::string& program, const std::vector<std::string>& arguments);

std::string read_file(const std::filesystem::path& file);

}  // namespace gnomon::tests
