// Loaded before the C++ library (LD_PRELOAD), it lets operator new fail now and then while the file
// GNOMON_FAULTS/no_memory exists, which holds two numbers: of how many allocations one fails, and the bytes from which an
// allocation may fail. Programs need no change.
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string_view>

namespace {

constexpr unsigned kLooksAtTheFile = 128;  // one in so many allocations

std::atomic<unsigned> allocations{0};
std::atomic<unsigned> failures_in{0};  // one fails of so many; 0: none
std::atomic<size_t> least_bytes{0};

// Without C++ allocations of its own. The daemon's helpers inherit this library, but may open no file.
void look() {
  static const char* const folder = std::getenv("GNOMON_FAULTS");
  if (!folder || std::string_view(program_invocation_short_name) != "gnomond") return;
  char path[512];
  std::snprintf(path, sizeof path, "%s/no_memory", folder);
  char text[64] = {};
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  const ssize_t length = file < 0 ? 0 : read(file, text, sizeof text - 1);
  if (file >= 0) close(file);
  unsigned one_in = 0;
  size_t bytes = 0;
  if (length <= 0 || std::sscanf(text, "%u %zu", &one_in, &bytes) != 2) one_in = 0;
  least_bytes = bytes;
  failures_in = one_in;
}

bool fails(size_t bytes) {
  if (allocations++ % kLooksAtTheFile == 0) look();
  const unsigned one_in = failures_in;
  if (one_in == 0 || bytes < least_bytes) return false;
  static thread_local unsigned state = 0x9e3779b9u + static_cast<unsigned>(gettid());
  state = state * 1664525u + 1013904223u;
  if ((state >> 8) % one_in != 0) return false;
  static std::atomic<bool> said{false};
  constexpr char kSaid[] = "an allocation was refused\n";  // for the test, which reads the log
  if (!said.exchange(true)) (void)!write(STDERR_FILENO, kSaid, sizeof kSaid - 1);
  return true;
}

// What nobody caught says where it came from, for addr2line.
const bool says_where = [] {
  std::set_terminate([] {
    void* frames[32];
    backtrace_symbols_fd(frames, backtrace(frames, 32), STDERR_FILENO);
    std::abort();
  });
  return true;
}();

void* allocate(size_t bytes) {
  void* const memory = fails(bytes) ? nullptr : std::malloc(bytes ? bytes : 1);
  if (!memory) throw std::bad_alloc();
  return memory;
}

void* allocate(size_t bytes, std::align_val_t alignment) {
  const auto step = static_cast<size_t>(alignment);
  void* const memory = fails(bytes) ? nullptr : std::aligned_alloc(step, (bytes + step - 1) / step * step);
  if (!memory) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(size_t bytes) { return allocate(bytes); }
void* operator new[](size_t bytes) { return allocate(bytes); }
void* operator new(size_t bytes, std::align_val_t alignment) { return allocate(bytes, alignment); }
void* operator new[](size_t bytes, std::align_val_t alignment) { return allocate(bytes, alignment); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, size_t, std::align_val_t) noexcept { std::free(memory); }
