// Notifications to a service manager (systemd), and the sockets and memory that it keeps for this service. Without a
// service manager the calls have no effect. Any thread.
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

// Watchdog interval; nullopt if the watchdog is disabled.
std::optional<std::chrono::microseconds> patience();

enum class SocketKind { stream, datagram };  // a listening TCP socket; a UDP socket

// Returns a socket of this kind and port that the manager opened and that is not taken yet, nullopt if there is none;
// the caller owns it. It stays open across restarts, so that clients that connect meanwhile wait instead of being
// refused.
std::optional<int> take_socket(SocketKind kind, uint16_t port);

// Returns memory that a previous process stored under this name, nullopt if there is none; the caller owns it.
std::optional<int> take_memory(const std::string& name);
// Stores the descriptor for the next process, in place of what was stored under this name before. No effect if the
// manager stores none (FileDescriptorStoreMax=).
void keep_memory(const std::string& name, int descriptor);

// Closes the sockets and memory that were not taken; returns their number.
int close_untaken();

}  // namespace gnomon::daemon::supervisor
