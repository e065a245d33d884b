// Counts every use of operator new in the program. In a file of its own, out of the optimiser's sight.
#pragma once

#include <cstdint>

namespace gnomon::bench {

uint64_t allocations();

}  // namespace gnomon::bench
