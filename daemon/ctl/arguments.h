// What gnomonctl's command line says, and what its commands have in common.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/ctl/admin_client.h"
#include "daemon/ctl/fleet.h"
#include "daemon/ctl/init.h"
#include "daemon/ctl/secrets.h"

namespace gnomon::ctl {

struct Arguments {
  AdminAccess admin;
  std::string token_file;
  bool json = false;
  std::string session;
  std::string why;
  std::optional<uint64_t> stay_out_s;
  std::string scene;
  uint32_t device = 0;
  double interval_s = 1;
  uint32_t count = 0;
  CertsRequest certs;
  InitRequest init;
  DoorRequest door;
  std::string fleet, node;
  uint32_t light = 0;
  nlohmann::json light_change = nlohmann::json::object();
  std::string lights_file;
  int exit_after_error = EXIT_FAILURE;  // of the program, if the command fails
};

constexpr int kExitUsage = 2;  // of the program, after a command line that it does not understand

// An error of the command line itself, which a command finds out.
inline Error wrong_usage(Arguments& arguments, const Error& error) {
  arguments.exit_after_error = kExitUsage;
  return error;
}

using Command = std::function<Result<void>(Arguments&)>;

inline void print(const std::string& text) { std::fputs(text.c_str(), stdout); }

inline Result<AdminAccess> access_of(const Arguments& arguments) {
  AdminAccess access = arguments.admin;
  if (!arguments.token_file.empty()) {
    std::ifstream file(arguments.token_file);
    if (!std::getline(file, access.token)) return Error{arguments.token_file + ": cannot be read"};
  }
  return access;
}

// ASCII alone, as others chose the names in it.
inline std::string json_text(const nlohmann::json& json, int indent) { return json.dump(indent, ' ', true) + "\n"; }

}  // namespace gnomon::ctl
