// Processors: those that this process may use, those near a device, and binding threads to some of them.
//
// On a machine with several NUMA nodes a frame is encoded on the node to which its device writes masks, so that reading
// them does not cross the link between nodes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace gnomon::daemon {

using Cores = std::vector<uint32_t>;  // Linux's numbers, increasing; if empty, any

// Parses a list as Linux writes it: "0-3,8,10-11".
Result<Cores> parse_cores(std::string_view list);

// The processors that the calling thread may run on, as restricted by taskset, a cpuset or systemd's CPUAffinity.
Cores usable_cores();

// Returns those of `usable` on the node of a device on the PCI bus ("0000:65:00.0"). Empty if the device has no
// address, if all of `usable` are near it (as with one node), or if none is. `devices`: sysfs's folder; another one in
// tests.
Cores cores_near(std::string_view pci_address, const Cores& usable,
                 const std::filesystem::path& devices = "/sys/bus/pci/devices");

// Binds the calling thread to these processors; no effect if `cores` is empty. Error if the kernel refuses.
Result<void> stay_on(const Cores& cores);

// The number of encode workers if it is not configured: a quarter of the cores. The others are left to sealing and
// sending, the render threads and the rest of the machine.
uint32_t default_encode_threads(const Cores& usable);

}  // namespace gnomon::daemon
