// Processors: those that this process may use, those near a device, and threads that stay on some of them.
//
// On a machine of several NUMA nodes a frame is encoded on the node that its device writes masks to, where reading
// them does not cross the link between nodes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace gnomon::daemon {

using Cores = std::vector<uint32_t>;  // numbers as Linux gives them, increasing; empty: any

// As Linux writes such lists: "0-3,8,10-11". Error: anything else.
Result<Cores> parse_cores(std::string_view list);

// The calling process may run on these: what taskset, a cpuset or systemd's CPUAffinity left.
Cores usable_cores();

// Of `usable`, those on the node of a device on the PCI bus ("0000:65:00.0"). Empty: the device has no address or the
// machine one node, or none of them is usable. `devices`: sysfs's list; elsewhere in tests.
Cores cores_near(std::string_view pci_address, const Cores& usable,
                 const std::filesystem::path& devices = "/sys/bus/pci/devices");

// The calling thread runs on these from now on. Empty: nothing changes. Error: the kernel says no.
Result<void> stay_on(const Cores& cores);

// How many workers encode where nobody has said: a quarter of the cores, the others are for sealing and sending, the
// render threads and the machine.
uint32_t default_encode_threads(const Cores& usable);

}  // namespace gnomon::daemon
