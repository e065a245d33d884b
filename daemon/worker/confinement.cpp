#include "daemon/worker/confinement.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>

#include "common/log.h"

namespace gnomon::daemon {
namespace {

Error because(const char* what, int error) { return Error{std::string(what) + ": " + std::strerror(error)}; }

// What the daemon itself is limited to stays the limit, if that is less. `warned`: how much before the last limit, at
// which the kernel kills, there is the one that sends the signal of the resource.
Result<void> limit(int resource, const char* what, uint64_t most, uint64_t warned = 0) {
  rlimit value{};
  if (getrlimit(static_cast<__rlimit_resource_t>(resource), &value) != 0) return because(what, errno);
  value.rlim_max = std::min<rlim_t>(value.rlim_max, most + warned);
  value.rlim_cur = std::min<rlim_t>({value.rlim_cur, value.rlim_max, most});
  if (setrlimit(static_cast<__rlimit_resource_t>(resource), &value) != 0) return because(what, errno);
  return {};
}

// Everything that the first version of Landlock knows, so that the ruleset works with every kernel that has it.
constexpr uint64_t kAllAccess =
    LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_READ_FILE |
    LANDLOCK_ACCESS_FS_READ_DIR | LANDLOCK_ACCESS_FS_REMOVE_DIR | LANDLOCK_ACCESS_FS_REMOVE_FILE |
    LANDLOCK_ACCESS_FS_MAKE_CHAR | LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_MAKE_REG |
    LANDLOCK_ACCESS_FS_MAKE_SOCK | LANDLOCK_ACCESS_FS_MAKE_FIFO | LANDLOCK_ACCESS_FS_MAKE_BLOCK |
    LANDLOCK_ACCESS_FS_MAKE_SYM;

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) close(fd);
  }
};

// glibc 2.36 has no wrappers for Landlock's calls.
Result<void> allow_folder(const std::filesystem::path& folder) {
  landlock_ruleset_attr rules{};
  rules.handled_access_fs = kAllAccess;
  const Descriptor ruleset{static_cast<int>(syscall(SYS_landlock_create_ruleset, &rules, sizeof rules, 0))};
  if (ruleset.fd < 0) {
    log::warning("this kernel has no Landlock: scenes are read with the daemon's own access to files",
                 {{"why", std::strerror(errno)}});
    return {};
  }
  if (!folder.empty()) {
    const Descriptor opened{open(folder.c_str(), O_PATH | O_CLOEXEC)};
    if (opened.fd < 0) return because(folder.c_str(), errno);
    landlock_path_beneath_attr beneath{};
    beneath.allowed_access = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
    beneath.parent_fd = opened.fd;
    if (syscall(SYS_landlock_add_rule, ruleset.fd, LANDLOCK_RULE_PATH_BENEATH, &beneath, 0) != 0) {
      return because("Landlock", errno);
    }
  }
  if (syscall(SYS_landlock_restrict_self, ruleset.fd, 0) != 0) return because("Landlock", errno);
  return {};
}

// What reading files, memory, arithmetic on several threads and one line of log need.
constexpr int kAllowed[] = {SCMP_SYS(read),
                            SCMP_SYS(pread64),
                            SCMP_SYS(readv),
                            SCMP_SYS(write),
                            SCMP_SYS(writev),
                            SCMP_SYS(openat),
                            SCMP_SYS(close),
                            SCMP_SYS(lseek),
                            SCMP_SYS(fstat),
                            SCMP_SYS(newfstatat),
                            SCMP_SYS(stat),
                            SCMP_SYS(lstat),
                            SCMP_SYS(statx),
                            SCMP_SYS(readlink),
                            SCMP_SYS(readlinkat),
                            SCMP_SYS(getdents64),
                            SCMP_SYS(access),
                            SCMP_SYS(faccessat),
                            SCMP_SYS(faccessat2),
                            SCMP_SYS(fcntl),
                            SCMP_SYS(fadvise64),
                            SCMP_SYS(mmap),
                            SCMP_SYS(munmap),
                            SCMP_SYS(mremap),
                            SCMP_SYS(mprotect),
                            SCMP_SYS(madvise),
                            SCMP_SYS(brk),
                            SCMP_SYS(futex),
                            SCMP_SYS(sched_yield),
                            SCMP_SYS(clock_gettime),
                            SCMP_SYS(gettimeofday),
                            SCMP_SYS(time),
                            SCMP_SYS(getrandom),
                            SCMP_SYS(getpid),
                            SCMP_SYS(gettid),
                            SCMP_SYS(tgkill),
                            SCMP_SYS(rt_sigreturn),
                            SCMP_SYS(rt_sigaction),
                            SCMP_SYS(rt_sigprocmask),
                            SCMP_SYS(getcwd),
                            SCMP_SYS(uname),
                            SCMP_SYS(ioctl),
                            SCMP_SYS(exit),
                            SCMP_SYS(exit_group),
                            SCMP_SYS(rseq),
                            SCMP_SYS(set_robust_list),
                            SCMP_SYS(sched_getaffinity)};

// Threads may be started, processes may not. The flags of clone3 lie in memory, where no filter sees them: it is said to
// be missing, upon which glibc calls clone.
int allow_threads(scmp_filter_ctx filter) {
  const scmp_arg_cmp thread = SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, CLONE_THREAD);
  const int clone = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(clone), 1, thread);
  return clone != 0 ? clone : seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
}

Result<void> allow_calls() {
  const std::unique_ptr<void, void (*)(scmp_filter_ctx)> filter(seccomp_init(SCMP_ACT_KILL_PROCESS),
                                                                seccomp_release);
  if (!filter) return Error{"seccomp: no filter can be made"};
  for (const int call : kAllowed) {
    if (const int done = seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 0); done != 0) {
      return because("seccomp", -done);
    }
  }
  if (const int done = allow_threads(filter.get()); done != 0) return because("seccomp", -done);
  const int done = seccomp_load(filter.get());
  // Limits, a process of its own and Landlock still hold where a kernel was built without seccomp.
  if (done == -EINVAL || done == -ENOSYS) {
    log::warning("this kernel has no seccomp: a scene's reader may call whatever the daemon may");
    return {};
  }
  return done == 0 ? Result<void>() : because("seccomp", -done);
}

}  // namespace

Result<void> limit_resources(const Confinement& to) {
  if (auto done = limit(RLIMIT_CORE, "limiting core dumps", 0); !done) return done;
  if (to.max_memory_bytes > 0) {
    if (auto done = limit(RLIMIT_AS, "limiting memory", to.max_memory_bytes); !done) return done;
  }
  if (to.max_cpu_seconds > 0) {
    if (auto done = limit(RLIMIT_CPU, "limiting processor time", to.max_cpu_seconds, 1); !done) return done;
  }
  if (to.max_file_bytes > 0) return limit(RLIMIT_FSIZE, "limiting files", to.max_file_bytes);
  return {};
}

Result<void> confine(const Confinement& to) {
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return because("giving up privileges", errno);
  if (auto done = limit_resources(to); !done) return done;
  if (auto done = allow_folder(to.folder); !done) return done;
  return allow_calls();
}

}  // namespace gnomon::daemon
