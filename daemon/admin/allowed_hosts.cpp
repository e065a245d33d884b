#include "daemon/admin/allowed_hosts.h"

#include <algorithm>
#include <cctype>

namespace gnomon::daemon {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return std::tolower(c); });
  return out;
}

struct Authority {
  std::string name;  // an IPv6 address without its brackets
  std::string port;  // empty if none is named
};

Authority authority_of(std::string_view text) {
  const bool bracketed = text.starts_with('[');
  const size_t end = bracketed ? text.find(']') : text.find(':');
  if (end == std::string_view::npos) return {lower(text), ""};
  const std::string name = lower(bracketed ? text.substr(1, end - 1) : text.substr(0, end));
  const std::string_view rest = text.substr(bracketed ? end + 1 : end);
  return {name, std::string(rest.starts_with(':') ? rest.substr(1) : rest)};
}

std::string usual_port(const Caller& caller) { return caller.encrypted ? "443" : "80"; }

}  // namespace

bool AllowedHosts::allows_host(std::string_view host, const Caller& caller) const {
  Authority asked = authority_of(host);
  if (asked.name.empty()) return false;
  if (asked.port.empty()) asked.port = usual_port(caller);
  const bool ours = asked.name == "localhost" || asked.name == caller.reached;
  if (ours && asked.port == std::to_string(caller.reached_port)) return true;
  return std::any_of(configured_.begin(), configured_.end(), [&](const std::string& text) {
    const Authority known = authority_of(text);
    return known.name == asked.name && (known.port.empty() || known.port == asked.port);
  });
}

bool AllowedHosts::allows_origin(std::string_view origin, const Caller& caller) const {
  const std::string_view scheme = caller.encrypted ? "https://" : "http://";
  return origin.starts_with(scheme) && allows_host(origin.substr(scheme.size()), caller);
}

}  // namespace gnomon::daemon
