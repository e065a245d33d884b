// netsim between a client and the daemon.
#pragma once

#include <csignal>

#include "tests/system/e2e/daemon.h"

namespace gnomon::tests {

// The daemon's ports at another address of this machine, through a simulated link.
class Relay {
 public:
  Relay(const Daemon& daemon, std::vector<std::string> link) : address_{"127.0.0.2", daemon.address().port} {
    link.insert(link.end(), {"--listen", address_.host, "--to", daemon.address().host, "--tcp",
                             std::to_string(daemon.address().port), "--udp", std::to_string(daemon.data_port())});
    process_.emplace("netsim", link, folder_.path());
    eventually([&] { return process_->output().find("relaying") != std::string::npos || !process_->running(); });
  }

  const client::Address& address() const { return address_; }
  Process& process() { return *process_; }

  // What it has to say in the end.
  std::string end() {
    process_->signal(SIGTERM);
    process_->wait();
    return process_->output();
  }

 private:
  TemporaryFolder folder_;
  client::Address address_;
  std::optional<Process> process_;
};

}  // namespace gnomon::tests
