// What a service manager (systemd) is told about us, and the sockets that it keeps for us. Without one, nothing
// happens. Any thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace gnomon::daemon::supervisor {

// Clients are served, for the first time or again after reloading().
void ready(const std::string& status);
void reloading();
void stopping();
void status(const std::string& text);  // one line, for `systemctl status`
void alive();

// How long we may say nothing before we are killed; empty: for ever.
std::optional<std::chrono::microseconds> patience();

enum class SocketKind { stream, datagram };  // a listening TCP socket; a UDP socket

// A socket of this kind and port that was opened for us and not taken yet; the caller owns it. It stays open between
// two lives of ours: who connects meanwhile waits instead of being refused.
std::optional<int> take_socket(SocketKind kind, uint16_t port);

// Memory that an earlier life of ours gave into keeping under this name; the caller owns it.
std::optional<int> take_memory(const std::string& name);
// Keeps a descriptor for our next life, if the manager does that (FileDescriptorStoreMax=); in the place of what it kept
// under this name before.
void keep_memory(const std::string& name, int descriptor);

// Closes what nobody took; says how many.
int close_untaken();

}  // namespace gnomon::daemon::supervisor
