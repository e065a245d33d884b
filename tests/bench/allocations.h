// Counts every use of operator new in the program. Defined in a file of its own, so that the optimiser cannot elide it.
#pragma once

#include <cstdint>

namespace gnomon::bench {

uint64_t allocations();

}  // namespace gnomon::bench
