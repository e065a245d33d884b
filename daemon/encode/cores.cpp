#include "daemon/encode/cores.h"

#include <sched.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

namespace gnomon::daemon {
namespace {

constexpr uint32_t kMostCores = 1 << 14;

struct FreeSet {
  void operator()(cpu_set_t* set) const { CPU_FREE(set); }
};
using Set = std::unique_ptr<cpu_set_t, FreeSet>;

const size_t kSetBytes = CPU_ALLOC_SIZE(kMostCores);

Set empty_set() {
  Set set(CPU_ALLOC(kMostCores));
  CPU_ZERO_S(kSetBytes, set.get());
  return set;
}

// Removes a number from the front of `text`; returns false if there is none below kMostCores.
bool take_number(std::string_view& text, uint32_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || number >= kMostCores) return false;
  text.remove_prefix(static_cast<size_t>(end - text.data()));
  return true;
}

bool take(std::string_view& text, char what) {
  if (text.empty() || text.front() != what) return false;
  text.remove_prefix(1);
  return true;
}

std::string first_line(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

}  // namespace

Result<Cores> parse_cores(std::string_view list) {
  Cores cores;
  const Error error{std::string("not a list of processors: '") + std::string(list) + "'"};
  for (bool more = !list.empty(); more; more = take(list, ',')) {
    uint32_t first = 0, last = 0;
    if (!take_number(list, first)) return error;
    last = first;
    if (take(list, '-') && !take_number(list, last)) return error;
    if (last < first || (!cores.empty() && first <= cores.back())) return error;
    for (uint32_t core = first; core <= last; ++core) cores.push_back(core);
  }
  if (!list.empty()) return error;
  return cores;
}

Cores usable_cores() {
  const Set set = empty_set();
  Cores cores;
  if (sched_getaffinity(0, kSetBytes, set.get()) != 0) return cores;
  for (uint32_t core = 0; core < kMostCores; ++core) {
    if (CPU_ISSET_S(core, kSetBytes, set.get())) cores.push_back(core);
  }
  return cores;
}

Cores cores_near(std::string_view pci_address, const Cores& usable, const std::filesystem::path& devices) {
  if (pci_address.empty()) return {};
  const auto local = parse_cores(first_line(devices / pci_address / "local_cpulist"));
  if (!local) return {};
  Cores near;
  std::set_intersection(local->begin(), local->end(), usable.begin(), usable.end(), std::back_inserter(near));
  if (near.size() == usable.size()) return {};
  return near;
}

Result<void> stay_on(const Cores& cores) {
  if (cores.empty()) return {};
  const Set set = empty_set();
  for (const uint32_t core : cores) CPU_SET_S(core, kSetBytes, set.get());
  if (sched_setaffinity(0, kSetBytes, set.get()) != 0) return Error{std::strerror(errno)};
  return {};
}

uint32_t default_encode_threads(const Cores& usable) {
  return std::max<uint32_t>(1, static_cast<uint32_t>(usable.size() / 4));
}

}  // namespace gnomon::daemon
