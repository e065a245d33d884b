// Where the daemon makes the socket for operators of this machine, and where their tool looks for it.
#pragma once

#include <filesystem>
#include <vector>

namespace gnomon::daemon {

// For admin.socket: auto. admin.sock in $RUNTIME_DIRECTORY, which systemd sets, else in $XDG_RUNTIME_DIR/gnomon; empty if
// neither variable is set.
std::filesystem::path usual_admin_socket();

// Those that a gnomonctl without --admin tries, in this order: that of this environment's daemon, that of the packaged
// unit.
std::vector<std::filesystem::path> admin_sockets_to_try();

}  // namespace gnomon::daemon
