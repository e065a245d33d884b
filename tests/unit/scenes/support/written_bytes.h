// What a function writes to a file, as bytes.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace gnomon::scenes::testing {

// `write` gets the file and returns a Result.
template <class Write>
std::vector<std::byte> written_bytes(Write write) {
  char* data = nullptr;
  size_t size = 0;
  std::FILE* file = open_memstream(&data, &size);
  EXPECT_TRUE(write(file));
  std::fclose(file);
  const auto* begin = reinterpret_cast<const std::byte*>(data);
  std::vector<std::byte> bytes(begin, begin + size);
  std::free(data);
  return bytes;
}

}  // namespace gnomon::scenes::testing
