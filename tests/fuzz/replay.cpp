// Runs a target over a folder of inputs and over mutations of them, always the same ones: what the test suite runs where
// there is no libFuzzer.
//
//   PROGRAM CORPUS_FOLDER [MUTATIONS_OF_EACH]
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/target.h"

namespace {

using Input = std::vector<uint8_t>;

std::vector<Input> read_corpus(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Input> corpus;
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return corpus;
}

// Damage of every kind: bits, numbers at the edges of their range, cuts, repeats, another input's tail.
void mutate(Input& input, const Input& other, std::mt19937& random) {
  const auto place = [&](size_t size) { return size == 0 ? 0 : random() % size; };
  for (uint32_t steps = 1 + random() % 4; steps > 0; --steps) {
    if (input.empty()) input.push_back(static_cast<uint8_t>(random()));
    const size_t at = place(input.size());
    const auto here = input.begin() + static_cast<std::ptrdiff_t>(at);
    switch (random() % 6) {
      case 0: input[at] ^= static_cast<uint8_t>(1u << random() % 8); break;
      case 1: input[at] = static_cast<uint8_t>(random()); break;
      case 2:
        std::fill(here, here + static_cast<std::ptrdiff_t>(std::min<size_t>(4, input.size() - at)),
                  random() % 2 ? 0xff : 0x00);
        break;
      case 3: input.resize(at); break;
      case 4:
        input.insert(input.end(), other.begin() + static_cast<std::ptrdiff_t>(place(other.size())), other.end());
        break;
      case 5:
        input.erase(here,
                    here + static_cast<std::ptrdiff_t>(std::min<size_t>(1 + random() % 8, input.size() - at)));
        break;
    }
  }
  constexpr size_t kLongest = 1 << 16;
  if (input.size() > kLongest) input.resize(kLongest);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const std::vector<Input> corpus = read_corpus(argv[1]);
  const int mutations = argc > 2 ? std::stoi(argv[2]) : 200;
  if (corpus.empty()) {
    std::fprintf(stderr, "%s: no inputs\n", argv[1]);
    return 1;
  }
  std::mt19937 random(1);
  for (const Input& seed : corpus) {
    LLVMFuzzerTestOneInput(seed.data(), seed.size());
    for (int i = 0; i < mutations; ++i) {
      Input input = seed;
      mutate(input, corpus[random() % corpus.size()], random);
      LLVMFuzzerTestOneInput(input.data(), input.size());
    }
  }
  std::printf("%zu inputs, %d mutations of each\n", corpus.size(), mutations);
  return 0;
}
