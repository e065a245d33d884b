#include "client/cli/options.h"

#include <charconv>
#include <fstream>

#include "protocol/types.h"

namespace gnomon::client {

Result<Size> parse_size(std::string_view text, uint32_t least) {
  const char* const end = text.data() + text.size();
  uint32_t width = 0, height = 0;
  const auto first = std::from_chars(text.data(), end, width);
  const bool divided = first.ec == std::errc{} && first.ptr != end && *first.ptr == 'x';
  const auto second = divided ? std::from_chars(first.ptr + 1, end, height) : first;
  const auto allowed = [&](uint32_t side) { return side >= least && side <= protocol::kMaxSide; };
  if (!divided || second.ec != std::errc{} || second.ptr != end || !allowed(width) || !allowed(height)) {
    return Error{std::string("'").append(text) + "' is no size: WIDTHxHEIGHT, each from " + std::to_string(least) +
                 " to " + std::to_string(protocol::kMaxSide)};
  }
  return Size{static_cast<uint16_t>(width), static_cast<uint16_t>(height)};
}

Result<Transport> parse_transport(std::string_view text) {
  if (text == "auto") return Transport::automatic;
  if (text == "udp") return Transport::udp;
  if (text == "tcp") return Transport::tcp;
  return Error{std::string(text).append(": no transport; allowed: auto, udp, tcp")};
}

Result<std::string> read_token(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string token;
  if (!in) return Error{"cannot read token file " + file.string()};
  std::getline(in, token);
  if (token.empty()) return Error{"token file " + file.string() + " is empty"};
  return token;
}

}  // namespace gnomon::client
