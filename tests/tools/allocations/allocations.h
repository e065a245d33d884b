// Counts every use of operator new in a program that is linked with gnomon_counts_allocations.
#pragma once

#include <cstdint>

namespace gnomon::test {

uint64_t allocations();

}  // namespace gnomon::test
