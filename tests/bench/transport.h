// The cases of gnomon-bench transport, one file for each subject: a case measures one thing and returns its rows.
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/result.h"

namespace gnomon::bench {

struct TransportOptions {
  std::chrono::duration<double> seconds{4};  // of each measurement
  bool quick = false;                        // runs every code path once; the figures are meaningless
};

struct TransportCase {
  const char* name;
  std::function<Result<std::vector<nlohmann::ordered_json>>(const TransportOptions&)> run;
};

std::vector<TransportCase> seal_cases();  // transport_seal.cpp
std::vector<TransportCase> send_cases();  // transport_send.cpp
std::vector<TransportCase> link_cases();  // transport_link.cpp
std::vector<TransportCase> junk_cases();  // transport_junk.cpp

}  // namespace gnomon::bench
