#include "daemon/service/supervisor.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <systemd/sd-daemon.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <utility>
#include <vector>

namespace gnomon::daemon::supervisor {
namespace {

struct Given {
  std::mutex mutex;
  std::vector<int> sockets;
  std::vector<std::pair<std::string, int>> memories;
  Given() {
    // The environment is not changed: sd_listen_fds checks by LISTEN_PID that the descriptors are for this process.
    char** names = nullptr;
    const int count = sd_listen_fds_with_names(0, &names);
    for (int i = 0; i < count; ++i) {
      const int descriptor = SD_LISTEN_FDS_START + i;
      if (sd_is_socket(descriptor, AF_UNSPEC, 0, -1) > 0) {
        sockets.push_back(descriptor);
      } else {
        memories.emplace_back(names[i], descriptor);
      }
      std::free(names[i]);
    }
    std::free(names);
  }
};

Given& given() {
  static Given instance;
  return instance;
}

bool matches(int socket, SocketKind kind, uint16_t port) {
  const int type = kind == SocketKind::stream ? SOCK_STREAM : SOCK_DGRAM;
  const int listening = kind == SocketKind::stream ? 1 : -1;
  return sd_is_socket_inet(socket, AF_UNSPEC, type, listening, port) > 0;
}

// A line break in a status would begin another assignment of the notification.
std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

uint64_t monotonic_us() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<uint64_t>(now.tv_sec) * 1'000'000 + static_cast<uint64_t>(now.tv_nsec) / 1000;
}

}  // namespace

void ready(const std::string& text) { sd_notify(0, ("READY=1\nSTATUS=" + one_line(text)).c_str()); }

// MONOTONIC_USEC is for service managers that support Type=notify-reload.
void reloading() {
  sd_notify(0, ("RELOADING=1\nMONOTONIC_USEC=" + std::to_string(monotonic_us()) + "\nSTATUS=reloading").c_str());
}

void stopping() { sd_notify(0, "STOPPING=1\nSTATUS=stopping"); }

void status(const std::string& text) { sd_notify(0, ("STATUS=" + one_line(text)).c_str()); }

void alive() { sd_notify(0, "WATCHDOG=1"); }

std::optional<std::chrono::microseconds> patience() {
  uint64_t us = 0;
  if (sd_watchdog_enabled(0, &us) <= 0) return std::nullopt;
  return std::chrono::microseconds(us);
}

std::optional<int> take_socket(SocketKind kind, uint16_t port) {
  Given& all = given();
  std::lock_guard lock(all.mutex);
  const auto found = std::find_if(all.sockets.begin(), all.sockets.end(),
                                  [&](int socket) { return port != 0 && matches(socket, kind, port); });
  if (found == all.sockets.end()) return std::nullopt;
  const int socket = *found;
  all.sockets.erase(found);
  return socket;
}

std::optional<int> take_memory(const std::string& name) {
  Given& all = given();
  std::lock_guard lock(all.mutex);
  const auto found = std::find_if(all.memories.begin(), all.memories.end(),
                                  [&](const auto& memory) { return memory.first == name; });
  if (found == all.memories.end()) return std::nullopt;
  const int descriptor = found->second;
  all.memories.erase(found);
  return descriptor;
}

void keep_memory(const std::string& name, int descriptor) {
  sd_notify(0, std::string("FDSTOREREMOVE=1\nFDNAME=").append(name).c_str());
  sd_pid_notify_with_fds(0, 0, std::string("FDSTORE=1\nFDPOLL=0\nFDNAME=").append(name).c_str(), &descriptor, 1);
}

int close_untaken() {
  Given& all = given();
  std::lock_guard lock(all.mutex);
  const int count = static_cast<int>(all.sockets.size() + all.memories.size());
  for (const int socket : all.sockets) close(socket);
  for (const auto& [name, descriptor] : all.memories) close(descriptor);
  all.sockets.clear();
  all.memories.clear();
  return count;
}

}  // namespace gnomon::daemon::supervisor
