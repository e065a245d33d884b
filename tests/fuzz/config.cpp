// A configuration file: a configuration, or an error that says where.
#include "daemon/config/config.h"
#include "tests/fuzz/target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto config = gnomon::daemon::parse_config(text, "fuzz.yaml");
  gnomon::fuzz::require(config || config.error().message.find("fuzz.yaml") == 0, "an error names the file");
  return 0;
}
